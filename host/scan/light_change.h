#pragma once
#include <span>

#include "host/core/range_image.h"
#include "host/core/scanner_model.h"

namespace stria {

/// Takes back what the changing light on a turning surface does to spacetime pulses. While a point
/// passes the sheet its irradiance E, the cosine of incidence over distance and width of the beam,
/// changes too; a pulse E(s) exp(-(s - s0)^2 / 2 w^2) peaks w^2 d ln E / ds after s0. Each point is
/// moved along its image path by as much, with E from its own normal: 0.02 mm on a turntable with a
/// beam of 0.5 mm, hardly anything on a rail. Points without a normal, spatial fall-backs, and
/// those lit so flatly that E changes by half over a width stay. Further returns stay.
/// @param image     normals written
/// @param channels  of each cell's pulse; looked at where the mask is set
void correct_light_change(RangeImage& image, std::span<const Channel* const> channels);

}  // namespace stria

#pragma once
#include <cstddef>

#include "host/fusion/facet.h"
#include "host/fusion/range_surface.h"
#include "host/fusion/volume.h"

namespace stria {

/// Adds a scan's surface to the volume. For every voxel whose line of sight meets a triangle, the
/// signed distance along that line, positive in front, with the weights interpolated over the
/// triangle. A voxel takes exactly one triangle of each layer of the surface: triangles that share
/// an edge share its plane of sight and take opposite sides of it. Where the camera moves, an
/// edge's plane goes through the mean of its ends' stations (off by < 1 um within the ramp of a
/// rail's profile). Sums are integers: scans may come in any order. Throws stria::Error before the
/// volume would exceed max_bytes. Source: Curless & Levoy 1996, section 3; ramp as in VripPack.
void integrate(SdfVolume& volume, const RangeSurface& surface, const RampLengths& ramp,
               std::size_t max_bytes);

}  // namespace stria

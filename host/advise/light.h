#pragma once
#include "host/advise/lens.h"
#include "host/advise/scanner.h"

namespace stria {

/// Electrons a second in one pixel from the middle of a laser line on a diffuse surface that a lens
/// images: irradiance P cos(incidence) / (fan r sqrt(2 pi) sigma_b), radiance albedo / pi of it,
/// pi / (4 N_w^2) of that on the sensor, times pixel area, quantum efficiency and wavelength / (h
/// c). The working f-number N_w accounts for the image distance. Source: accuracy.md C, beam and
/// expected electrons; EMVA 1288 eq. 3 for photons.
struct LineLight {
    double power_mw = 0;
    double fan_rad = 0;
    double range_mm = 0;  ///< from the laser
    double sigma_b_mm = 0;
    double wavelength_nm = 0;
    double incidence_rad = 0;
    double albedo = 0;
};
double line_electrons_per_s(const LineLight& light, const SensorSpec& sensor, const Lens& lens);

}  // namespace stria

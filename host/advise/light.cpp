#include "host/advise/light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stria {
namespace {

constexpr double kPlanckTimesLight = 1.98644586e-25;  // J m

}  // namespace

double line_electrons_per_s(const LineLight& light, const SensorSpec& sensor, const Lens& lens) {
    const double irradiance_mw_per_mm2 =
        light.power_mw * std::max(0.0, std::cos(light.incidence_rad)) /
        (light.fan_rad * light.range_mm * std::sqrt(2 * std::numbers::pi) * light.sigma_b_mm);
    const double n = working_f_number(lens);
    const double on_sensor_w_per_m2 = 1000 * irradiance_mw_per_mm2 * light.albedo / (4 * n * n);
    const double pixel_m = sensor.pixel_um * 1e-6;
    return on_sensor_w_per_m2 * pixel_m * pixel_m * sensor.quantum_efficiency *
           light.wavelength_nm * 1e-9 / kPlanckTimesLight;
}

}  // namespace stria

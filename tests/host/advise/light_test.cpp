#include "host/advise/light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stria {
namespace {

TEST(Light, ElectronsByHand) {
    // 1 mW over 1 rad at 400 mm, sigma 0.5 mm: 1 / (400 * 2.50663 * 0.5) = 1.99471e-3 mW/mm^2
    // = 1.99471 W/m^2. Sensor, N = 5 at infinity, albedo 1: / 100. A 5 um pixel: 25e-12 m^2.
    // Photons of 650 nm: h c / lambda = 3.0561e-19 J. Half of them count.
    SensorSpec sensor;
    sensor.pixel_um = 5;
    sensor.quantum_efficiency = 0.5;
    const Lens lens{.focal_mm = 1e-3, .focus_mm = 1e6, .f_number = 5, .pixel_um = 5};
    const LineLight light{.power_mw = 1,
                          .fan_rad = 1,
                          .range_mm = 400,
                          .sigma_b_mm = 0.5,
                          .wavelength_nm = 650,
                          .incidence_rad = 0,
                          .albedo = 1};
    const double expected = 1.99471 / 100 * 25e-12 / 3.05609e-19 * 0.5;
    EXPECT_NEAR(line_electrons_per_s(light, sensor, lens) / expected, 1, 1e-4);
}

TEST(Light, FallsWithTheCosineOfIncidenceAndTheSquareOfTheAperture) {
    const SensorSpec sensor;
    Lens lens{.focal_mm = 10, .focus_mm = 400, .f_number = 4, .pixel_um = 3.45};
    LineLight light{5, 0.5, 400, 0.3, 650, 0, 0.8};
    const double facing = line_electrons_per_s(light, sensor, lens);
    light.incidence_rad = M_PI / 3;
    EXPECT_NEAR(line_electrons_per_s(light, sensor, lens) / facing, 0.5, 1e-12);
    light.incidence_rad = 0;
    lens.f_number = 8;
    EXPECT_NEAR(line_electrons_per_s(light, sensor, lens) / facing, 0.25, 1e-12);
}

}  // namespace
}  // namespace stria

#include "host/advise/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace stria {
namespace {

TEST(Lens, FocalLengthIsThatOfTheThinLens) {
    // 10 mm of sensor for 100 mm at 220 mm: m = 0.1, f = 220 * 0.1 / 1.1 = 20 mm, v = 22 mm.
    const double f = focal_length_mm(10, 100, 220);
    EXPECT_NEAR(f, 20, 1e-12);
    const Lens lens{.focal_mm = f, .focus_mm = 220, .f_number = 4, .pixel_um = 5};
    EXPECT_NEAR(image_distance_mm(lens), 22, 1e-12);
    EXPECT_NEAR(working_f_number(lens), 4.4, 1e-12);
    EXPECT_NEAR(aperture_mm(lens), 5, 1e-12);
    EXPECT_NEAR(pixel_on_object_mm(lens, 220), 0.05, 1e-12);
    EXPECT_NEAR(sin_aperture(lens, 220), std::sin(std::atan(2.5 / 220)), 1e-15);
}

TEST(Lens, OfACalibratedCameraHasItsImageDistance) {
    std::mt19937 rng(11);
    std::uniform_real_distribution<double> u(0, 1);
    for (int i = 0; i < 300; ++i) {
        const double fx = 500 + 4000 * u(rng), pixel = 1.5 + 6 * u(rng), focus = 80 + 900 * u(rng);
        const Lens lens = lens_of(fx, pixel, 4, focus);
        EXPECT_NEAR(image_distance_mm(lens), fx * pixel * 1e-3, 1e-9) << fx << " " << focus;
        EXPECT_NEAR(1 / lens.focal_mm, 1 / focus + 1000 / (fx * pixel), 1e-9);
        EXPECT_NEAR(pixel_on_object_mm(lens, focus), focus / fx, 1e-12);
    }
}

TEST(Lens, FootprintByHand) {
    const Lens lens{
        .focal_mm = 20, .focus_mm = 220, .f_number = 4, .pixel_um = 5, .aberration_px = 0.5};
    const Footprint sharp = footprint_at(lens, 650, 220);
    EXPECT_NEAR(sharp.diffraction_mm, 0.42 * 0.65e-3 * 4.4 * 10, 1e-12);  // 12.0 um on the part
    EXPECT_EQ(sharp.defocus_mm, 0);
    EXPECT_NEAR(sharp.aberration_mm, 0.025, 1e-12);
    EXPECT_NEAR(sharp.pixel_mm, 0.05 / std::sqrt(12), 1e-12);
    const Footprint near = footprint_at(lens, 650, 198);
    // The cone of a 5 mm aperture, 22 of 220 mm from its tip: 0.5 mm wide, a quarter of that.
    EXPECT_NEAR(near.defocus_mm, 0.125, 1e-12);
    EXPECT_NEAR(near.sigma_mm(),
                std::sqrt(std::pow(near.diffraction_mm, 2) + 0.125 * 0.125 +
                          std::pow(near.aberration_mm, 2) + std::pow(near.pixel_mm, 2)),
                1e-12);
}

TEST(Lens, QuarterOfADiscIsItsStandardDeviation) {
    // What the defocus term stands on: marginal variance of a uniform disc by summation.
    double sum = 0, squares = 0;
    const int n = 1000;
    for (int i = 0; i < n; ++i) {
        const double x = (2.0 * i + 1) / n - 1, chord = std::sqrt(1 - x * x);
        sum += chord;
        squares += chord * x * x;
    }
    EXPECT_NEAR(std::sqrt(squares / sum), 2.0 / 4, 1e-4);  // diameter 2
}

}  // namespace
}  // namespace stria

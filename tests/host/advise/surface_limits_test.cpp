#include "host/advise/surface_limits.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firmware/core/angle.h"

namespace stria {
namespace {

TEST(SurfaceLimits, ReflectanceStepsOfAccuracyA1) {
    const struct {
        double ratio, shift;
    } table[] = {{1.5, 0.16}, {2, 0.28}, {3, 0.44}, {5, 0.64}, {10, 0.90}, {20, 1.16}, {50, 1.48}};
    for (const auto& row : table) {
        EXPECT_NEAR(reflectance_step_shift(row.ratio), row.shift, 0.006) << row.ratio;
        EXPECT_NEAR(reflectance_step_shift(1 / row.ratio), row.shift, 0.006) << row.ratio;
    }
    EXPECT_EQ(reflectance_step_shift(1), 0);
}

TEST(SurfaceLimits, TheCardsOf1995) {
    // accuracy.md A.1: a 0.25 mm box seen at 30 deg, sigma_b = 0.45 mm: spatial 0.47 mm, 86 % less.
    const EdgeError error = edge_error(10, 0.25 / std::sqrt(12), 0.45, 30 * kDegree);
    EXPECT_NEAR(error.spatial_mm * std::tan(30 * kDegree), 0.47, 0.005);
    EXPECT_NEAR(1 - error.ratio, 0.86, 0.003);
    EXPECT_NEAR(error.spacetime_mm / error.spatial_mm, error.ratio, 1e-12);
    // "max spacetime shift at K = 10 = 0.26 p = 0.065 mm"
    EXPECT_NEAR(error.spacetime_mm * std::tan(30 * kDegree), 0.065, 0.0005);
}

/// Share of the half sphere facing the camera that the laser lights, by counting.
TEST(SurfaceLimits, SharesOfASphereByCounting) {
    for (const double angle : {10 * kDegree, 25 * kDegree, 60 * kDegree}) {
        long both = 0, camera = 0;
        const int n = 400;
        for (int i = 0; i < n; ++i)
            for (int k = 0; k < n; ++k) {
                const double z = (2.0 * i + 1) / n - 1, phi = 2 * M_PI * (k + 0.5) / n;
                const double x = std::sqrt(1 - z * z) * std::cos(phi);
                if (z <= 0) continue;
                ++camera;
                both += std::sin(angle) * x + std::cos(angle) * z > 0;
            }
        EXPECT_NEAR(occlusion_of(angle).hemisphere_share,
                    static_cast<double>(both) / static_cast<double>(camera), 2e-3)
            << angle;
    }
}

/// Does light from `slope` (x per depth) reach the middle of a slot's floor, w = 1?
bool reaches_middle(double depth, double slope) { return std::abs(slope) * depth <= 0.5; }

TEST(SurfaceLimits, SlotsByTracingRays) {
    for (const double angle : {15 * kDegree, 30 * kDegree}) {
        const Occlusion seen = occlusion_of(angle);
        const double straight = seen.hole_depth_per_width, turned = seen.best_hole_depth_per_width;
        EXPECT_TRUE(reaches_middle(0.999 * straight, std::tan(angle)));
        EXPECT_FALSE(reaches_middle(1.001 * straight, std::tan(angle)));
        EXPECT_TRUE(reaches_middle(0.999 * turned, std::tan(angle / 2)));
        EXPECT_FALSE(reaches_middle(1.001 * turned, std::tan(angle / 2)));
        EXPECT_NEAR(seen.steepest_wall_rad + angle, M_PI / 2, 1e-12);
    }
}

}  // namespace
}  // namespace stria

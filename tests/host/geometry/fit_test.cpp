#include "host/geometry/fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

namespace stria {
namespace {

using Eigen::Vector3d;

TEST(FitPlane, RecoversThePlaneThatPointsWerePutOn) {
    std::mt19937 rng(1);
    std::normal_distribution<double> n(0.0, 1.0);
    for (int trial = 0; trial < 200; ++trial) {
        const Vector3d normal = Vector3d(n(rng), n(rng), n(rng)).normalized();
        const double offset = 300.0 * n(rng);
        std::vector<Vector3d> points;
        for (int i = 0; i < 30; ++i) {
            Vector3d p(50 * n(rng), 50 * n(rng), 50 * n(rng));
            points.push_back(p + (offset - normal.dot(p)) * normal);
        }
        const PlaneFit fit = fit_plane(points);
        const double sign = fit.normal.dot(normal) < 0 ? -1.0 : 1.0;
        ASSERT_LT((sign * fit.normal - normal).norm(), 1e-12);
        ASSERT_NEAR(sign * fit.offset_mm, offset, 1e-9);  // mm, rounding at 300 mm
        ASSERT_LT(fit.rms_mm, 1e-11);
    }
}

TEST(FitPlane, ReportsTheResidualOfAKnownSawtooth) {
    std::vector<Vector3d> points;  // z alternates by +-0.1 over a symmetric square
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 4; ++y) points.emplace_back(x, y, (x + y) % 2 == 0 ? 0.1 : -0.1);
    const PlaneFit fit = fit_plane(points);
    EXPECT_NEAR(fit.rms_mm, 0.1, 0.002);  // the best plane tilts a little: < 2 % of 0.1
    EXPECT_NEAR(fit.singular_values.x(), std::sqrt(20.0),
                1e-3);  // 4 x 5, the variance of 0..3 x 16
    EXPECT_THROW(fit_plane(std::vector<Vector3d>(2)), std::invalid_argument);
}

TEST(FitSphere, RecoversASphereFromASmallCap) {
    std::mt19937 rng(2);
    std::normal_distribution<double> n(0.0, 1.0);
    for (int trial = 0; trial < 200; ++trial) {
        const Vector3d centre(100 * n(rng), 100 * n(rng), 300 + 100 * n(rng));
        const double radius = 5.0 + 20.0 * std::abs(n(rng));
        const Vector3d towards = Vector3d(n(rng), n(rng), n(rng)).normalized();
        std::vector<Vector3d> points;
        while (points.size() < 100) {
            const Vector3d d = Vector3d(n(rng), n(rng), n(rng)).normalized();
            if (d.dot(towards) > 0.7) points.push_back(centre + radius * d);
        }
        const SphereFit fit = fit_sphere(points);
        ASSERT_TRUE(fit.converged);
        ASSERT_LT((fit.centre - centre).norm(), 1e-7);  // mm, rounding x the cap's weak lever
        ASSERT_NEAR(fit.radius_mm, radius, 1e-7);
        ASSERT_LT(fit.rms_mm, 1e-9);
    }
}

TEST(FitSphere, IsUnbiasedWhereTheAlgebraicFitIsNot) {
    std::mt19937 rng(3);
    std::normal_distribution<double> n(0.0, 1.0);
    double sum = 0;
    constexpr int kTrials = 200;
    for (int trial = 0; trial < kTrials; ++trial) {
        std::vector<Vector3d> points;
        for (int i = 0; i < 500; ++i) {
            const Vector3d d = Vector3d(n(rng), n(rng), n(rng)).normalized();
            points.push_back((25.0 + 0.1 * n(rng)) * d);
        }
        sum += fit_sphere(points).radius_mm - 25.0;
    }
    // One fit scatters by 0.1 / sqrt(500) = 0.0045 mm, the mean of 200 by 0.00032: four sigmas.
    EXPECT_NEAR(sum / kTrials, 0.0, 0.0013);
}

TEST(FitSphere, SaysSoWhenThereIsNoSphere) {
    std::vector<Vector3d> plane;
    for (int i = 0; i < 20; ++i) plane.emplace_back(i % 5, i / 5, 1.0);
    EXPECT_FALSE(fit_sphere(plane).converged);
    EXPECT_FALSE(fit_sphere(std::vector<Vector3d>(4, Vector3d(1, 2, 3))).converged);
    plane[3].x() = std::nan("");
    EXPECT_FALSE(fit_sphere(plane).converged);
    EXPECT_THROW(fit_sphere(std::vector<Vector3d>(3)), std::invalid_argument);
}

TEST(FitSphere, OfGivenRadiusFindsTheCentreAlone) {
    std::mt19937 rng(5);
    std::normal_distribution<double> n(0.0, 1.0);
    const Vector3d centre(40, -20, 400);
    std::vector<Vector3d> points;
    while (points.size() < 300) {
        const Vector3d d = Vector3d(n(rng), n(rng), n(rng)).normalized();
        if (d.z() < -0.5) points.push_back(centre + 15.0 * d);
    }
    const SphereFit exact = fit_sphere_of_radius(points, 15.0);
    ASSERT_TRUE(exact.converged);
    EXPECT_LT((exact.centre - centre).norm(), 1e-9);  // mm, rounding at 400 mm
    EXPECT_LT(exact.rms_mm, 1e-9);
    // Given 0.1 more, residuals |p - c| - r vanish on average where sum of n_z (n_z d - 0.1) does:
    // d = 0.1 <n_z> / <n_z^2> = 0.1 (3/4) / (7/12) for n_z even over 0.5 .. 1.
    const SphereFit larger = fit_sphere_of_radius(points, 15.1);
    EXPECT_EQ(larger.radius_mm, 15.1);
    EXPECT_NEAR(larger.centre.z() - centre.z(), 0.1 * 9 / 7, 0.01);
    EXPECT_THROW(fit_sphere_of_radius(points, 0), std::invalid_argument);
    EXPECT_THROW(fit_sphere_of_radius(std::vector<Vector3d>(3), 1), std::invalid_argument);
}

}  // namespace
}  // namespace stria

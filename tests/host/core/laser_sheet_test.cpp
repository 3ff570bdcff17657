#include "host/core/laser_sheet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/host/core/random_models.h"

namespace stria {
namespace {

/// The point of the sheet at fan angle phi, `range` from the apex before it is lifted by the bow.
Eigen::Vector3d on_sheet(const LaserSheet& sheet, double phi, double range, double lift_rad) {
    const Eigen::Vector3d t = sheet.normal.cross(sheet.central_ray);
    const Eigen::Vector3d ray = std::cos(phi) * sheet.central_ray + std::sin(phi) * t;
    return sheet.apex + range * (ray + std::tan(lift_rad) * sheet.normal);
}

TEST(LaserSheet, FlatDistanceIsThePlanes) {
    RandomModels random(1);
    for (int i = 0; i < 100; ++i) {
        const LaserSheet sheet = random.sheet(0);
        const Eigen::Vector3d p = random.vector(300);
        EXPECT_NEAR(signed_distance(sheet, p), sheet.normal.dot(p) - sheet.offset_mm, 1e-12);
    }
}

TEST(LaserSheet, KnowsTheFanAngleOfAPoint) {
    RandomModels random(2);
    const LaserSheet sheet = random.sheet(0);
    for (const double phi : {-0.6, 0.0, 0.3})
        EXPECT_NEAR(fan_angle(sheet, on_sheet(sheet, phi, 250, 0.01)), phi, 1e-12);
}

TEST(LaserSheet, BowLiftsTowardsThePositiveNormal) {
    RandomModels random(3);
    for (int i = 0; i < 100; ++i) {
        LaserSheet sheet = random.sheet(0.02);
        for (const double phi : {-0.5, -0.2, 0.0, 0.4}) {
            const double bow = sheet.bow2 * phi * phi + sheet.bow3 * phi * phi * phi;
            const Eigen::Vector3d p = on_sheet(sheet, phi, 300, bow);
            EXPECT_NEAR(signed_distance(sheet, p), 0, 1e-11);  // mm, rounding at 300 mm
            EXPECT_GT(signed_distance(sheet, p + 0.1 * sheet.normal), 0.099);
            EXPECT_LT(signed_distance(sheet, p - 0.1 * sheet.normal), -0.099);
        }
    }
    LaserSheet sheet = random.sheet(0);
    sheet.bow2 = 0.01;  // lifted: a point of the flat plane lies below it
    EXPECT_LT(signed_distance(sheet, on_sheet(sheet, 0.3, 300, 0)), 0);
    EXPECT_LT(signed_distance(sheet, on_sheet(sheet, -0.3, 300, 0)), 0);
    sheet.bow2 = 0;
    sheet.bow3 = 0.01;  // odd: the sides differ
    EXPECT_LT(signed_distance(sheet, on_sheet(sheet, 0.3, 300, 0)), 0);
    EXPECT_GT(signed_distance(sheet, on_sheet(sheet, -0.3, 300, 0)), 0);
}

TEST(LaserSheet, ReflectionKeepsDistancesUpToTheNormalsSide) {
    RandomModels random(4);
    int turned = 0;
    for (int i = 0; i < 300; ++i) {
        const LaserSheet sheet = random.sheet(0.02);
        const Eigen::Vector3d m = random.unit(), q = random.vector(100);
        const double h = random.uniform(-10, 10);
        const LaserSheet image = reflected(sheet, m, q, h);
        const Eigen::Vector3d p = Eigen::Vector3d(0, 0, 300) + random.vector(50);
        const Eigen::Vector3d p_image = p - 2 * (m.dot(p - q) - h) * m;
        EXPECT_GE(image.offset_mm, 0);
        EXPECT_NEAR(image.normal.dot(image.apex), image.offset_mm, 1e-10);  // apex in the sheet
        // +normal is chosen so that offset_mm > 0: both sign conventions must occur.
        const Eigen::Vector3d n_image = sheet.normal - 2 * m.dot(sheet.normal) * m;
        const double side = image.normal.dot(n_image);
        EXPECT_NEAR(std::abs(side), 1, 1e-12);
        turned += side < 0;
        EXPECT_NEAR(signed_distance(image, p_image), side * signed_distance(sheet, p), 1e-9);
        EXPECT_NEAR(sigma_at(image, p_image), sigma_at(sheet, p), 1e-12);
    }
    EXPECT_GT(turned, 0);
    EXPECT_LT(turned, 300);
}

TEST(LaserSheet, ReflectedTwiceIsItself) {
    RandomModels random(5);
    for (int i = 0; i < 100; ++i) {
        const LaserSheet sheet = random.sheet(0.02);
        const Eigen::Vector3d m = random.unit(), q = random.vector(100);
        const LaserSheet again = reflected(reflected(sheet, m, q, 3), m, q, 3);
        EXPECT_LT((again.normal - sheet.normal).norm(), 1e-12);
        EXPECT_LT((again.apex - sheet.apex).norm(), 1e-10);
        EXPECT_LT((again.central_ray - sheet.central_ray).norm(), 1e-12);
        EXPECT_NEAR(again.offset_mm, sheet.offset_mm, 1e-10);
        EXPECT_EQ(again.bow2, sheet.bow2);
        EXPECT_EQ(again.bow3, sheet.bow3);
    }
}

TEST(LaserSheet, BeamWidensAsAGaussianBeamDoes) {
    LaserSheet sheet;
    sheet.apex = {0, 0, 0};
    sheet.waist_sigma_mm = 0.1;
    sheet.waist_at_mm = 200;
    sheet.wavelength_nm = 650;
    EXPECT_NEAR(sigma_at(sheet, {0, 0, 200}), 0.1, 1e-12);
    // w = 2 sigma; z_R = pi w0^2 / lambda: sqrt(2) wider there
    const double rayleigh = std::numbers::pi * 0.2 * 0.2 / 650e-6;
    EXPECT_NEAR(sigma_at(sheet, {0, 0, 200 + rayleigh}), 0.1 * std::numbers::sqrt2, 1e-12);
    EXPECT_NEAR(sigma_at(sheet, {0, 0, 200 - rayleigh / 2}), 0.1 * std::sqrt(1.25), 1e-12);
}

TEST(LaserSheet, NormalisedDescribesTheSameSheet) {
    RandomModels random(6);
    for (int i = 0; i < 100; ++i) {
        const LaserSheet sheet = random.sheet(0.02);
        LaserSheet other = sheet;  // the same plane by another normal; apex and ray moved off it
        other.normal = -3.0 * sheet.normal;
        other.offset_mm = -3.0 * sheet.offset_mm;
        other.bow2 = -sheet.bow2;
        const LaserSheet back = normalised(other);
        EXPECT_LT((back.normal - sheet.normal).norm(), 1e-12);
        EXPECT_NEAR(back.offset_mm, sheet.offset_mm, 1e-10);
        EXPECT_NEAR(back.central_ray.norm(), 1, 1e-12);
        EXPECT_NEAR(back.normal.dot(back.central_ray), 0, 1e-12);
        EXPECT_NEAR(back.normal.dot(back.apex), back.offset_mm, 1e-10);
        const Eigen::Vector3d p = on_sheet(sheet, 0.3, 280, 0.004);
        EXPECT_NEAR(signed_distance(back, p), signed_distance(sheet, p), 1e-9);
    }
}

}  // namespace
}  // namespace stria

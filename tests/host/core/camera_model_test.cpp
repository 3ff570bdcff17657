#include "host/core/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace stria {
namespace {

CameraModel pinhole() { return {LensKind::pinhole, 640, 480, 500, 510, 320, 240, {}}; }

TEST(CameraModel, ProjectsThePinholeByHand) {
    const auto pixel = project(pinhole(), {30, -20, 100});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), 320 + 500 * 0.3, 1e-12);
    EXPECT_NEAR(pixel->y(), 240 - 510 * 0.2, 1e-12);
}

TEST(CameraModel, SeesNothingBehindItself) {
    EXPECT_FALSE(project(pinhole(), {0, 0, 0}));
    EXPECT_FALSE(project(pinhole(), {1, 1, -5}));
    EXPECT_FALSE(project(pinhole(), {1, 1, std::numeric_limits<double>::quiet_NaN()}));
}

TEST(CameraModel, ImageReachesHalfAPixelBeyondTheCentres) {
    const CameraModel camera = pinhole();
    EXPECT_TRUE(camera.contains({-0.5, -0.5}));
    EXPECT_TRUE(camera.contains({639.5, 479.5}));
    EXPECT_FALSE(camera.contains({639.6, 0}));
    EXPECT_FALSE(camera.contains({0, -0.6}));
}

/// OpenCV's documented formulas (calib3d, "Detailed Description"), written out.
Eigen::Vector2d distorted(const std::array<double, 8>& k, double x, double y) {
    const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const double radial =
        (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / (1 + k[5] * r2 + k[6] * r4 + k[7] * r6);
    return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
            y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

TEST(CameraModel, DistortsAsOpenCvDocuments) {
    CameraModel camera = pinhole();
    camera.kind = LensKind::rational8;
    camera.distortion = {0.3, -0.2, 0.01, -0.02, 0.05, 0.1, 0.02, -0.01};
    for (const double x : {-0.7, 0.0, 0.4})
        for (const double y : {-0.5, 0.1, 0.6}) {
            const Eigen::Vector2d d = distorted(camera.distortion, x, y);
            const auto pixel = project(camera, {2 * x, 2 * y, 2});
            ASSERT_TRUE(pixel);
            EXPECT_NEAR(pixel->x(), 500 * d.x() + 320, 1e-10);
            EXPECT_NEAR(pixel->y(), 510 * d.y() + 240, 1e-10);
        }
}

TEST(CameraModel, RayIsTheInverseOfProjection) {
    std::mt19937 rng(1);
    const auto uniform = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(rng);
    };
    for (int i = 0; i < 500; ++i) {
        CameraModel camera = pinhole();
        camera.kind = i % 2 ? LensKind::brown5 : LensKind::rational8;
        camera.distortion = {uniform(-0.3, 0.3), uniform(-0.1, 0.1), uniform(-0.01, 0.01),
                             uniform(-0.01, 0.01), uniform(-0.03, 0.03)};
        if (i % 2 == 0)
            for (std::size_t k = 5; k < 8; ++k) camera.distortion[k] = uniform(-0.05, 0.05);
        const Eigen::Vector3d direction(uniform(-0.6, 0.6), uniform(-0.45, 0.45), 1);
        const auto pixel = project(camera, 250 * direction);
        ASSERT_TRUE(pixel);
        EXPECT_LT((ray_through(camera, *pixel) - direction).norm(), 1e-12) << i;  // of 1: rounding
    }
}

/// r with r (1 + k r^2) = d, by Cardano's formula; the branch that contains 0.
double undistorted_radius(double k, double d) {
    const double scale = std::sqrt(3 * std::abs(k));
    const double argument = 1.5 * d * scale;
    return k > 0 ? 2 / scale * std::sinh(std::asinh(argument) / 3)
                 : 2 / scale * std::sin(std::asin(argument) / 3);
}

TEST(CameraModel, UndistortsStrongRadialLensesAsCardanoDoes) {
    for (const double k1 : {-0.3, -0.1, 0.1, 0.5, 2.0}) {
        CameraModel camera = pinhole();
        camera.kind = LensKind::brown5;
        camera.distortion[0] = k1;
        // Barrel distortion folds over at r^2 = 1 / (3 |k|): stay at 95 % of the greatest radius.
        const double fold = 2 / (3 * std::sqrt(3 * std::abs(k1)));
        const double greatest = k1 < 0 ? 0.95 * fold : 1.5;
        for (int i = 0; i <= 100; ++i) {
            const double d = greatest * i / 100;
            const Eigen::Vector3d ray =
                ray_through(camera, {320 + 500 * d * 0.6, 240 + 510 * d * 0.8});
            EXPECT_NEAR(std::hypot(ray.x(), ray.y()), undistorted_radius(k1, d), 1e-10)
                << "k1 " << k1 << ", d " << d;
        }
    }
}

TEST(CameraModel, FollowsAWideRationalLensToItsCorners) {
    // The wide lens of mrcal's documentation (OPENCV8, 6016 x 4016).
    const CameraModel camera = {LensKind::rational8,
                                6016,
                                4016,
                                2073.872915,
                                2077.452267,
                                3004.686823,
                                1997.377253,
                                {0.4791613797, 0.0266824914, 4.398264387e-05, -1.180073913e-05,
                                 8.959722542e-05, 0.7666912469, 0.09633561231, 0.001407513313}};
    for (int y = 0; y <= 4015; y += 55)
        for (int x = 0; x <= 6015; x += 55) {
            const Eigen::Vector3d ray = ray_through(camera, {x, y});
            const auto pixel = project(camera, ray);
            ASSERT_TRUE(pixel);
            EXPECT_LT((*pixel - Eigen::Vector2d(x, y)).norm(), 1e-8) << x << " " << y;  // px
        }
}

TEST(CameraModel, NamesItsKinds) {
    for (const LensKind kind : {LensKind::pinhole, LensKind::brown5, LensKind::rational8})
        EXPECT_EQ(lens_kind_from(name_of(kind)), kind);
    EXPECT_FALSE(lens_kind_from("fisheye"));
    EXPECT_EQ(distortion_count(LensKind::pinhole), 0);
    EXPECT_EQ(distortion_count(LensKind::brown5), 5);
    EXPECT_EQ(distortion_count(LensKind::rational8), 8);
}

TEST(CameraModel, NamesTheFieldThatIsWrong) {
    const auto why = [](auto change) {
        CameraModel camera = pinhole();
        change(camera);
        return validate(camera);
    };
    EXPECT_EQ(why([](CameraModel&) {}), "");
    EXPECT_EQ(why([](CameraModel& c) { c.width = 0; }).find("width"), 0U);
    EXPECT_EQ(why([](CameraModel& c) { c.height = 20000; }).find("height"), 0U);
    EXPECT_EQ(why([](CameraModel& c) { c.fx = -1; }).find("fx"), 0U);
    EXPECT_EQ(why([](CameraModel& c) { c.fy = std::nan(""); }).find("fy"), 0U);
    EXPECT_EQ(why([](CameraModel& c) { c.cy = std::nan(""); }).find("cy"), 0U);
    EXPECT_EQ(why([](CameraModel& c) { c.distortion[3] = std::nan(""); }).find("distortion"), 0U);
}

}  // namespace
}  // namespace stria

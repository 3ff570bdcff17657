#include "host/scan/light_change.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/core/pulse.h"
#include "tests/support/synthetic_scanner.h"

namespace stria {
namespace {

using Eigen::Vector3d;

/// A plane seen by a turntable's head: where the light that its points return over the axis travel
/// has its mean, by summing the light itself.
class TurningPlane : public testing::Test {
  protected:
    TurningPlane() : channel(test_support::turntable_scanner().channels.front()) {}

    /// Mean of s weighted with cos(incidence) / (r width) exp(-d^2 / 2 width^2).
    double mean_of_light(const Vector3d& point, const Vector3d& normal, double s0) const {
        double sum = 0, moment = 0;
        for (int i = -4000; i <= 4000; ++i) {
            const double s = s0 + i * 5e-5;
            const Rigid3 camera_from_scan = scan_from_camera(channel, s).inverse();
            const Vector3d at = camera_from_scan * point;
            const Vector3d to_laser = channel.sheet.apex - at;
            const double cosine =
                (camera_from_scan.rotation * normal).dot(to_laser) / to_laser.norm();
            const double width = sigma_at(channel.sheet, at);
            const double d = signed_distance(channel.sheet, at) / width;
            const double light =
                std::max(0.0, cosine) / (to_laser.norm() * width) * std::exp(-0.5 * d * d);
            sum += light;
            moment += light * s;
        }
        return moment / sum;
    }

    /// What triangulation makes of the point when its crossing is taken to be at s.
    RangePoint measured_at(const Vector3d& point, const Vector3d& normal, double s) const {
        const auto pixel =
            project(channel.camera, scan_from_camera(channel, s).inverse() * point).value();
        RangePoint told;
        told.position = triangulate(channel, pixel, s).value().point_in_scan;
        told.normal = normal.cast<float>();
        told.s = s;
        return told;
    }

    static RangePoint corrected(const RangePoint& point, const Channel& channel) {
        RangeImage image = make_range_image(1, 1);
        image.mask[0] = 1;
        image.points[0] = point;
        const Channel* const channels[] = {&channel};
        correct_light_change(image, channels);
        return image.points[0];
    }

    Channel channel;
};

TEST_F(TurningPlane, PointsReturnToTheirPlane) {
    double worst_before = 0, worst_after = 0;
    for (const double turn : {-0.7, -0.3, 0.0, 0.3, 0.7})  // rad, of the normal about the axis
        for (const double radius : {20.0, 35.0, 50.0}) {
            // in front of the axis and in the sheet at s = 0: towards (0.4, -1)
            const Vector3d point = radius * Vector3d(0.4, -1, 0.1).normalized();
            const Vector3d normal(std::sin(turn), -std::cos(turn), 0);
            const double s = mean_of_light(point, normal, 0);
            const RangePoint before = measured_at(point, normal, s);
            const RangePoint after = corrected(before, channel);
            const double error_before = std::abs(normal.dot(before.position - point));
            const double error_after = std::abs(normal.dot(after.position - point));
            EXPECT_LT(error_after, 0.15 * error_before + 5e-4)  // mm: the second order of the light
                << turn << ' ' << radius;
            worst_before = std::max(worst_before, error_before);
            worst_after = std::max(worst_after, error_after);
        }
    std::printf("off the plane by %.4f mm, corrected %.4f mm\n", worst_before, worst_after);
    EXPECT_GT(worst_before, 0.01);
}

TEST_F(TurningPlane, WhatCannotBeJudgedStays) {
    const Vector3d point = 30 * Vector3d(0.4, -1, 0).normalized(), normal(0, -1, 0);
    RangePoint told = measured_at(point, normal, 0.001);
    EXPECT_NE(corrected(told, channel).position, told.position);
    RangePoint spatial = told;
    spatial.flags = kPulseSpatialFallback;
    EXPECT_EQ(corrected(spatial, channel).position, told.position);
    RangePoint bare = told;
    bare.normal.setZero();
    EXPECT_EQ(corrected(bare, channel).position, told.position);
    RangePoint averted = told;
    averted.normal = Eigen::Vector3f(0, 1, 0);
    EXPECT_EQ(corrected(averted, channel).position, told.position);
}

}  // namespace
}  // namespace stria

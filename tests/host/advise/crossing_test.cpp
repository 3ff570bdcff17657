#include "host/advise/crossing.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/support/synthetic_scanner.h"

namespace stria {
namespace {

using Eigen::Vector3d;

TEST(Crossing, OfASweptSheetHoldsThePoint) {
    const Channel channel = test_support::swept_scanner().channels.front();
    std::mt19937 rng(9);
    std::uniform_real_distribution<double> u(-1, 1);
    for (int i = 0; i < 200; ++i) {
        const Vector3d p(80 * u(rng), 60 * u(rng), 450 + 60 * u(rng));
        const auto crossing = swept_crossing(channel, p);
        ASSERT_TRUE(crossing) << p.transpose();
        EXPECT_NEAR(signed_distance(crossing->sheet, p), 0, 1e-9) << p.transpose();
        // The way of the sheet by differences, its normal's sign put right.
        const double h = 1e-5;
        const double before = std::abs(signed_distance(sheet_at(channel, crossing->s - h), p));
        const double after = std::abs(signed_distance(sheet_at(channel, crossing->s + h), p));
        EXPECT_NEAR(crossing->mm_per_s, (before + after) / (2 * h), 1e-3 * crossing->mm_per_s);
    }
}

TEST(Crossing, OnTheAxisOfASweptMachineMovesTwiceTheMirrorsAngle) {
    const Channel channel = test_support::swept_scanner().channels.front();
    const auto crossing = crossing_at_depth(channel, 450);
    ASSERT_TRUE(crossing);
    // The mirror does not quite lie on its axis: the beam's speed is 2 r to within a per mille.
    EXPECT_NEAR(crossing->mm_per_s, 2 * crossing->pivot_mm, 2e-3 * 2 * crossing->pivot_mm);
    EXPECT_TRUE(crossing->in_image);
    EXPECT_NEAR(crossing->point_in_camera.z(), 450, 1e-9);
    // A wrong s shifts the point along its ray.
    EXPECT_NEAR(crossing->shift_per_s.norm(), crossing->along_ray_mm_per_s,
                1e-6 * crossing->along_ray_mm_per_s);
    EXPECT_NEAR(crossing->shift_per_s.cross(crossing->point_in_camera).norm(), 0,
                1e-6 * crossing->shift_per_s.norm() * 450);
}

TEST(Crossing, OfARailLiesOnTheSheetAndMovesWithTheHead) {
    const Channel channel = test_support::rail_scanner().channels.front();
    for (const double depth : {400.0, 450.0, 500.0}) {
        const auto crossing = crossing_at_depth(channel, depth);
        ASSERT_TRUE(crossing);
        EXPECT_NEAR(signed_distance(channel.sheet, crossing->point_in_camera), 0, 1e-9);
        EXPECT_NEAR(crossing->point_in_camera.z(), depth, 1e-9);
        EXPECT_NEAR(crossing->mm_per_s,
                    std::abs(channel.sheet.normal.dot(channel.axis.rail.direction)), 1e-9);
        EXPECT_TRUE(std::isinf(crossing->pivot_mm));
        // A wrong s shifts the point with the head.
        EXPECT_NEAR((crossing->shift_per_s - channel.axis.rail.direction).norm(), 0, 1e-9);
    }
}

TEST(Crossing, OfATableMovesByItsRadius) {
    const Channel channel = test_support::turntable_scanner().channels.front();
    const auto on_axis = crossing_at_depth(channel, 450);
    const auto nearer = crossing_at_depth(channel, 420);
    ASSERT_TRUE(on_axis && nearer);
    EXPECT_NEAR(on_axis->mm_per_s, 0, 1e-9);
    // A point at radius r moves by r, of which what lies across the sheet counts.
    EXPECT_GT(nearer->mm_per_s, 0.8 * nearer->pivot_mm);
    EXPECT_LE(nearer->mm_per_s, nearer->pivot_mm + 1e-9);
}

TEST(Crossing, RangeCoversEveryPointThatTheCameraSees) {
    const Channel channel = test_support::swept_scanner().channels.front();
    const auto range = axis_range(channel, 400, 500);
    ASSERT_TRUE(range);
    std::mt19937 rng(2);
    std::uniform_real_distribution<double> u(0, 1);
    for (int i = 0; i < 300; ++i) {
        const Eigen::Vector2d pixel(u(rng) * (channel.camera.width - 1),
                                    u(rng) * (channel.camera.height - 1));
        const auto crossing =
            swept_crossing(channel, (400 + 100 * u(rng)) * ray_through(channel.camera, pixel));
        ASSERT_TRUE(crossing);
        EXPECT_GE(crossing->s, range->from - 1e-6);
        EXPECT_LE(crossing->s, range->to + 1e-6);
    }
}

TEST(Crossing, FanOfARailReachesTheTopAndBottomRow) {
    Channel channel = test_support::rail_scanner().channels.front();
    channel.camera.distortion = {};
    channel.camera.cy = (channel.camera.height - 1) / 2.0;
    const double y = 400 * channel.camera.cy / channel.camera.fy;
    // The sheet leaves (180, 0, 0) towards (0, 0, 450): at a depth of 400 mm it is 400 / 450 of
    // the way along.
    const double laser_mm = std::hypot(180, 450) * 400 / 450;
    EXPECT_NEAR(fan_needed_rad(channel, 400, 400), 2 * std::atan(y / laser_mm) / 0.98, 1e-4);
}

TEST(Crossing, IsNotWhereTheSheetDoesNotReach) {
    const Channel channel = test_support::swept_scanner().channels.front();
    EXPECT_FALSE(swept_crossing(channel, Vector3d(0, 0, -300)));
    EXPECT_FALSE(swept_crossing(channel, Vector3d(-1e5, 0, 10)));
}

}  // namespace
}  // namespace stria

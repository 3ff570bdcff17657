#include "host/scan/profiler_frame.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "host/core/errors.h"
#include "tests/support/synthetic_scanner.h"

namespace stria {
namespace {

using Eigen::Vector3d;

TEST(ProfilerFrame, IsARotationWhoseYIsTheRailsTravel) {
    const ScannerModel model = test_support::rail_scanner();
    const Channel& channel = model.channels.front();
    const Rigid3 profiler = profiler_from_scan(channel, 10);
    EXPECT_TRUE(is_rigid(profiler, 1e-12));
    const Vector3d travel = (scan_from_camera(channel, 1) * Vector3d::Zero()) -
                            (scan_from_camera(channel, 0) * Vector3d::Zero());
    EXPECT_LT((profiler.rotation * travel.normalized() - Vector3d::UnitY()).norm(), 1e-12);
}

TEST(ProfilerFrame, HeightPointsFromTheSurfaceToTheLaser) {
    for (const ScannerModel& model :
         {test_support::rail_scanner(), test_support::swept_scanner()}) {
        const Channel& channel = model.channels.front();
        const Rigid3 profiler = profiler_from_scan(channel, 0);
        const auto surface = triangulate(channel, {320, 256}, 0);
        const Vector3d laser = scan_from_camera(channel, 0) * sheet_at(channel, 0).apex;
        EXPECT_GT((profiler * laser).z(), (profiler * surface->point_in_scan).z() + 100);  // mm
    }
}

TEST(ProfilerFrame, SweptTravelIsTheWayTheStripeMoves) {
    const ScannerModel model = test_support::swept_scanner();
    const Channel& channel = model.channels.front();
    const Rigid3 profiler = profiler_from_scan(channel, 0);
    // Where the middle of the stripe falls on a plane at 450 mm, before and after.
    const auto at = [&](double s) -> Vector3d {
        const LaserSheet sheet = sheet_at(channel, s);
        const double range = (450 - sheet.apex.z()) / sheet.central_ray.z();
        return profiler * (scan_from_camera(channel, s) * (sheet.apex + range * sheet.central_ray));
    };
    EXPECT_GT((at(0.01) - at(-0.01)).y(), 0);
}

TEST(ProfilerFrame, ATurntableHasNone) {
    EXPECT_THROW((void)profiler_from_scan(test_support::turntable_scanner().channels.front(), 0),
                 Error);
}

}  // namespace
}  // namespace stria

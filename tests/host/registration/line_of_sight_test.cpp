#include "host/registration/line_of_sight.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/bumpy_shape.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using Verdict = LineOfSight::Verdict;

TEST(LineOfSight, TellsFrontFromBehindAlongTheCamerasRays) {
    const SurfaceTree shape(testing::make_bumpy_shape(1, 4));
    std::mt19937 rng(1);
    RangeImage image =
        testing::take_view(shape, testing::looking_from(Vector3d(1, 0, 0), 300), {}, rng);
    for (const bool orthographic : {false, true}) {
        if (orthographic) image.stations.clear();  // the same points, seen along -z
        const ScanSurface surface = prepare_surface(image);
        const LineOfSight sight(surface, 2.0);
        int told_in_front = 0;
        for (std::size_t k = 0; k < 500; ++k) {
            const std::uint32_t i = surface.samples[k];
            const Vector3d &point = surface.points[i], &back = surface.to_camera[i];
            EXPECT_EQ(sight.at(point, 1.0), Verdict::near);
            // Near a silhouette the cells around see past the part: no verdict, never a wrong one.
            const Verdict before = sight.at(point + 60 * back, 1.0);
            EXPECT_TRUE(before == Verdict::in_front || before == Verdict::unknown);
            told_in_front += before == Verdict::in_front;
            EXPECT_EQ(sight.at(point - 60 * back, 1.0), Verdict::behind);
        }
        EXPECT_GT(told_in_front, 400);
        EXPECT_EQ(sight.at(surface.centre + Vector3d(500, 0, 0), 1.0), Verdict::unknown);
        if (!orthographic) {
            EXPECT_EQ(sight.at(Vector3d(0, 0, 10), 1.0), Verdict::unknown);
        }
    }
}

TEST(LineOfSight, GivesNoVerdictWhereTheCameraMoved) {
    const SurfaceTree shape(testing::make_bumpy_shape(1, 3));
    std::mt19937 rng(1);
    RangeImage image =
        testing::take_view(shape, testing::looking_from(Vector3d(1, 0, 0), 300), {}, rng);
    Station moved = image.stations.front();
    moved.s = 1;
    moved.camera_in_scan.x() += 50;
    image.stations.push_back(moved);
    const ScanSurface surface = prepare_surface(image);
    const LineOfSight sight(surface, 2.0);
    EXPECT_EQ(sight.at(surface.points[0] + Vector3d(0, 0, 50), 1.0), Verdict::unknown);
}

}  // namespace
}  // namespace stria

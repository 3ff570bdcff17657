#include "host/registration/matches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "host/registration/occupancy.h"
#include "tests/support/bumpy_shape.h"

namespace stria {
namespace {

using Eigen::Vector3d;

ScanSurface view_from(const Vector3d& direction) {
    static const SurfaceTree shape(testing::make_bumpy_shape(1, 4));
    std::mt19937 rng(1);
    return prepare_surface(testing::take_view(shape, testing::looking_from(direction, 300),
                                              {.width = 60, .height = 60, .pitch_mm = 2}, rng));
}

TEST(Occupancy, NeverDeniesAPointThatIsNear) {
    std::mt19937 rng(2);
    std::uniform_real_distribution<double> mm(-30.0, 30.0);
    std::vector<Vector3d> points;
    for (int i = 0; i < 100; ++i) points.emplace_back(mm(rng), 0.1 * mm(rng), mm(rng));
    const OccupancyGrid grid(points, 0.7);
    int denied = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        const Vector3d query(1.3 * mm(rng), mm(rng), 1.3 * mm(rng));
        double nearest = 1e300;
        for (const Vector3d& point : points) nearest = std::min(nearest, (point - query).norm());
        for (const double distance : {0.5, 0.7, 3.0, 9.0}) {
            const bool may = grid.may_be_near(query, distance);
            ASSERT_TRUE(may || nearest > distance) << query.transpose();
            denied += !may;
        }
    }
    EXPECT_GT(denied, 20000);  // it is worth asking
    EXPECT_TRUE(OccupancyGrid().may_be_near(Vector3d::Zero(), 1));
    EXPECT_TRUE(grid.may_be_near(Vector3d::Zero(), 1e9));  // beyond its coarsest cells: unknown
}

TEST(Matches, AgreeWithBruteForceWarmAndCold) {
    const ScanSurface source = view_from({1, 0, 0}), target = view_from({1, 1, 0});
    const Rigid3 truth =
        testing::looking_from({1, 1, 0}, 300).inverse() * testing::looking_from({1, 0, 0}, 300);
    const std::vector<std::uint32_t> samples = ordered_samples(source, 500);
    ASSERT_EQ(samples.size(), 500U);
    std::vector<std::uint32_t> warm;
    std::mt19937 rng(3);
    for (int round = 0; round < 6; ++round) {
        const Rigid3 pose = testing::random_motion(target.centre, 0.02, 1.0, rng) * truth;
        const MatchGates gates = {.max_distance_mm = 3.0, .min_normal_cosine = 0.7};
        const auto found = find_matches(source, target, pose, gates, samples, warm);
        std::size_t at = 0;
        for (const std::uint32_t index : samples) {
            const Vector3d point = pose * source.points[index];
            std::uint32_t nearest = 0;
            double best = 1e300;
            for (std::uint32_t k = 0; k < target.points.size(); ++k)
                if (const double d = (target.points[k] - point).norm(); d < best) {
                    best = d;
                    nearest = k;
                }
            const bool good =
                best <= 3.0 && !target.is_border[nearest] &&
                (pose.rotation * source.normals[index]).dot(target.normals[nearest]) >= 0.7;
            if (!good) continue;
            ASSERT_LT(at, found.size());
            ASSERT_EQ(found[at].source, index);
            ASSERT_EQ(found[at].target, nearest);
            ++at;
        }
        ASSERT_EQ(at, found.size());
        ASSERT_GT(at, 100U);
    }
}

TEST(OverlapRms, IsTheShiftOfAPlaneAlongItsNormal) {
    RangeImage image = make_range_image(30, 30);
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 30; ++x) {
            image.mask[image.cell(x, y)] = 1;
            image.points[image.cell(x, y)].position = Vector3d(x, -y, 0);
        }
    std::vector<ScanSurface> scans;
    scans.push_back(prepare_surface(image));
    scans.push_back(prepare_surface(image));
    Rigid3 lifted;
    lifted.translation = Vector3d(0.3, 0.2, 0.7);
    EXPECT_NEAR(overlap_rms_mm(list_of(scans), {Rigid3{}, lifted}), 0.7, 1e-12);
    lifted.translation.z() = 2.5;  // beyond the 2 mm
    EXPECT_EQ(overlap_rms_mm(list_of(scans), {Rigid3{}, lifted}), 0.0);
}

}  // namespace
}  // namespace stria

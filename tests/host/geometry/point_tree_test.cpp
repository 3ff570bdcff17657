#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/geometry/nearest.h"

namespace stria {
namespace {

using Eigen::Vector3d;

/// Clouds that trees get wrong: a lattice full of ties, a line, duplicates, and plain random.
std::vector<std::vector<Vector3d>> clouds() {
    std::mt19937 rng(5);
    std::uniform_real_distribution<double> mm(-10.0, 10.0);
    std::vector<std::vector<Vector3d>> all(4);
    for (int i = 0; i < 500; ++i) {
        all[0].emplace_back(mm(rng), mm(rng), mm(rng));
        all[1].emplace_back(i % 8, (i / 8) % 8, i / 64);
        all[2].emplace_back(0, mm(rng), 0);
        all[3].emplace_back(i % 3, 0, 0);
    }
    return all;
}

std::vector<PointTree::Hit> by_distance(const std::vector<Vector3d>& points, const Vector3d& q) {
    std::vector<PointTree::Hit> hits;
    for (std::size_t i = 0; i < points.size(); ++i)
        hits.push_back({static_cast<std::uint32_t>(i), std::sqrt((points[i] - q).squaredNorm())});
    std::stable_sort(hits.begin(), hits.end(),
                     [](const auto& a, const auto& b) { return a.distance_mm < b.distance_mm; });
    return hits;
}

TEST(PointTree, AgreesWithBruteForceIncludingTies) {
    std::mt19937 rng(6);
    std::uniform_real_distribution<double> mm(-12.0, 12.0);
    for (const auto& points : clouds()) {
        const PointTree tree(points);
        for (int trial = 0; trial < 300; ++trial) {
            Vector3d q(mm(rng), mm(rng), mm(rng));
            if (trial % 2 == 0) q = q.array().round() * 0.5;  // on lattice points and half-way
            const auto expected = by_distance(points, q);
            const auto nearest = tree.nearest(q, 100.0);
            ASSERT_TRUE(nearest);
            ASSERT_EQ(nearest->index, expected[0].index) << q.transpose();
            ASSERT_EQ(nearest->distance_mm, expected[0].distance_mm);

            const auto few = tree.nearest_few(q, 10);
            ASSERT_EQ(few.size(), 10U);
            for (std::size_t i = 0; i < few.size(); ++i) {
                ASSERT_EQ(few[i].index, expected[i].index) << i << " of " << q.transpose();
                ASSERT_EQ(few[i].distance_mm, expected[i].distance_mm);
            }
            const double radius = 3.0;
            std::vector<std::uint32_t> within;
            for (const auto& hit : expected)
                if (hit.distance_mm <= radius) within.push_back(hit.index);
            std::sort(within.begin(), within.end());
            ASSERT_EQ(tree.within(q, radius), within) << q.transpose();
        }
    }
}

TEST(PointTree, FindsNothingBeyondTheLimitAndSomethingOnIt) {
    const PointTree tree({Vector3d(0, 0, 0)});
    EXPECT_FALSE(tree.nearest(Vector3d(3, 4, 0), 4.999));
    ASSERT_TRUE(tree.nearest(Vector3d(3, 4, 0), 5.0));
    EXPECT_EQ(tree.nearest(Vector3d(3, 4, 0), 5.0)->distance_mm, 5.0);
    EXPECT_FALSE(tree.nearest(Vector3d(3, 4, 0), -1.0));
}

TEST(PointTree, PassesOverWhatIsNotFinite) {
    const double nan = std::nan("");
    const PointTree tree({Vector3d(nan, 0, 0), Vector3d(1, 0, 0), Vector3d(0, INFINITY, 0)});
    ASSERT_TRUE(tree.nearest(Vector3d::Zero(), 10.0));
    EXPECT_EQ(tree.nearest(Vector3d::Zero(), 10.0)->index, 1U);
    EXPECT_FALSE(tree.nearest(Vector3d(nan, 0, 0), 10.0));
    EXPECT_EQ(tree.nearest_few(Vector3d::Zero(), 5).size(), 1U);
    EXPECT_TRUE(tree.nearest_few(Vector3d::Zero(), 0).empty());

    const PointTree empty({});
    EXPECT_FALSE(empty.nearest(Vector3d::Zero(), 10.0));
    EXPECT_TRUE(empty.nearest_few(Vector3d::Zero(), 3).empty());
    EXPECT_TRUE(empty.within(Vector3d::Zero(), 3).empty());
}

}  // namespace
}  // namespace stria

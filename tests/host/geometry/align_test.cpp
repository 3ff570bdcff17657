#include "host/geometry/align.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>
#include <vector>

namespace stria {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> cloud(std::mt19937& rng, std::size_t count) {
    std::normal_distribution<double> mm(0.0, 50.0);
    std::vector<Vector3d> points(count);
    for (Vector3d& p : points) p = Vector3d(mm(rng), mm(rng), 300.0 + mm(rng));
    return points;
}

Rigid3 random_motion(std::mt19937& rng) {
    std::normal_distribution<double> n(0.0, 1.0);
    Vector6d delta;
    for (int i = 0; i < 6; ++i) delta[i] = n(rng) * (i < 3 ? 1.5 : 100.0);
    return rigid_from_vector(delta);
}

TEST(AlignPoints, RecoversAnyMotionFromThreePointsAndMore) {
    std::mt19937 rng(1);
    for (int trial = 0; trial < 300; ++trial) {
        const auto from = cloud(rng, 3 + static_cast<std::size_t>(trial % 5));
        const Rigid3 motion = random_motion(rng);
        std::vector<Vector3d> to;
        for (const Vector3d& p : from) to.push_back(motion * p);
        const Rigid3 found = align_points(from, to);
        ASSERT_TRUE(is_rigid(found, 1e-12));
        for (std::size_t i = 0; i < from.size(); ++i)
            ASSERT_LT((found * from[i] - to[i]).norm(), 1e-9) << trial;  // mm, rounding at 400 mm
    }
}

TEST(AlignPoints, IsALeastSquaresMinimum) {
    std::mt19937 rng(2);
    std::normal_distribution<double> noise(0.0, 5.0);
    const auto from = cloud(rng, 20);
    std::vector<Vector3d> to;
    std::vector<double> weights;
    for (const Vector3d& p : from) {
        to.push_back(p + Vector3d(noise(rng), noise(rng), noise(rng)));
        weights.push_back(0.1 + std::abs(noise(rng)));
    }
    const auto cost = [&](const Rigid3& motion) {
        double sum = 0;
        for (std::size_t i = 0; i < from.size(); ++i)
            sum += weights[i] * (to[i] - motion * from[i]).squaredNorm();
        return sum;
    };
    const Rigid3 found = align_points(from, to, weights);
    Vector3d centre = Vector3d::Zero();
    for (const Vector3d& p : to) centre += p / 20.0;
    for (int axis = 0; axis < 6; ++axis)
        for (double sign : {-1.0, 1.0}) {
            Vector6d step = Vector6d::Zero();
            step[axis] = sign * (axis < 3 ? 1e-4 : 1e-2);
            const Rigid3 about{Eigen::Matrix3d::Identity(), centre};
            EXPECT_GT(cost(about * rigid_from_vector(step) * about.inverse() * found), cost(found));
        }
}

TEST(AlignPoints, NeverMirrors) {
    std::mt19937 rng(3);
    const auto from = cloud(rng, 50);
    std::vector<Vector3d> to;
    for (const Vector3d& p : from) to.push_back(Vector3d(-p.x(), p.y(), p.z()));
    EXPECT_TRUE(is_rigid(align_points(from, to), 1e-12));
}

TEST(AlignPoints, AnswersDegenerateInputWithAValidMotion) {
    EXPECT_TRUE(is_rigid(align_points({}, {})));
    const std::vector<Vector3d> one = {Vector3d(1, 2, 3)}, other = {Vector3d(4, 5, 6)};
    const Rigid3 moved = align_points(one, other);
    EXPECT_TRUE(is_rigid(moved));
    EXPECT_LT((moved * one[0] - other[0]).norm(), 1e-12);
    const std::vector<Vector3d> line = {Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(2, 0, 0)};
    EXPECT_TRUE(is_rigid(align_points(line, line)));
    EXPECT_THROW(align_points(one, line), std::invalid_argument);
}

}  // namespace
}  // namespace stria

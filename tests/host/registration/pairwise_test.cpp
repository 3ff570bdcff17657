#include "host/registration/pairwise.h"

#include <gtest/gtest.h>

#include <random>

#include "firmware/core/angle.h"
#include "tests/support/bumpy_shape.h"

namespace stria {
namespace {

using Eigen::Vector3d;

class RegisterPair : public ::testing::Test {
  protected:
    static ScanSurface view(const Vector3d& direction, double sigma_mm, unsigned seed) {
        static const SurfaceTree shape(testing::make_bumpy_shape(1));
        std::mt19937 rng(seed);
        return prepare_surface(testing::take_view(shape, testing::looking_from(direction, 300),
                                                  {.sigma_mm = sigma_mm}, rng));
    }
    const Vector3d from_{1, 0.2, 0}, to_{1, 1, 0.1};
    const Rigid3 truth_ =
        testing::looking_from(to_, 300).inverse() * testing::looking_from(from_, 300);

    double turn_deg(const Rigid3& pose) const {
        return vector_from_rotation(pose.rotation * truth_.rotation.transpose()).norm() / kDegree;
    }
};

TEST_F(RegisterPair, FindsTheTruthFromAfar) {
    const ScanSurface source = view(from_, 0.02, 1), target = view(to_, 0.02, 2);
    std::mt19937 rng(3);
    for (const double off : {0.0, 3.0, 5.0})
        for (int trial = 0; trial < 3; ++trial) {
            const Rigid3 start =
                testing::random_motion(target.centre, off * kDegree, off, rng) * truth_;
            const PairResult result = register_pair(source, target, start);
            ASSERT_TRUE(result.converged) << off << ": " << result.reason;
            EXPECT_LT(turn_deg(result.target_from_source), 0.03) << off;
            EXPECT_LT((result.target_from_source * source.centre - truth_ * source.centre).norm(),
                      0.03)
                << off;  // mm, three times what one pair's noise leaves
            EXPECT_GT(result.matches, 1000U);
        }
}

TEST_F(RegisterPair, GivesTheInverseWhenExchanged) {
    const ScanSurface source = view(from_, 0.02, 1), target = view(to_, 0.02, 2);
    std::mt19937 rng(4);
    const Rigid3 start = testing::random_motion(target.centre, 2 * kDegree, 2, rng) * truth_;
    const JointOptions tight = {.tolerance_mm = 1e-5};
    const PairResult there = register_pair(source, target, start, tight);
    const PairResult back = register_pair(target, source, start.inverse(), tight);
    const Rigid3 loop = there.target_from_source * back.target_from_source;
    // The two solve the same sum of squares; they stop a tolerance apart.
    EXPECT_LT(vector_from_rotation(loop.rotation).norm() / kDegree, 1e-3);
    EXPECT_LT((loop * target.centre - target.centre).norm(), 1e-3);  // mm
}

TEST_F(RegisterPair, StaysWhereAScanMeetsItself) {
    const ScanSurface scan = view(from_, 0.02, 1);
    const PairResult result = register_pair(scan, scan, Rigid3{});
    EXPECT_TRUE(result.converged) << result.reason;
    EXPECT_LT(vector_from_rigid(result.target_from_source).norm(), 1e-9);
    EXPECT_LT(result.overlap_rms_mm, 1e-12);
}

TEST_F(RegisterPair, DoesNotClaimSuccessWithoutOverlap) {
    const ScanSurface source = view(from_, 0.02, 1), target = view(to_, 0.02, 2);
    Rigid3 far = truth_;
    far.translation.x() += 500;
    const PairResult result = register_pair(source, target, far);
    EXPECT_FALSE(result.converged);
    EXPECT_FALSE(result.reason.empty());
    EXPECT_EQ(result.open_directions, 6);
}

}  // namespace
}  // namespace stria

#include "calib/valley_solve.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "calib/arrow_system.h"

namespace stria {
namespace {

/// One shared block p of three, two poses of one: each pose is known through p alone.
struct Follows {
    double share;
    template <typename T>
    bool operator()(const T* p, const T* pose, T* residual) const {
        residual[0] = 1e3 * (pose[0] - share * p[0] * p[0] - p[1]);
        return true;
    }
};
/// p1 = p0^2 to 1e-3: a valley bent like a parabola. Along it p0 is known to 1 and drawn to 3.
struct Bent {
    template <typename T>
    bool operator()(const T* p, T* residual) const {
        residual[0] = 1e3 * (p[1] - p[0] * p[0]);
        residual[1] = p[0] - 3.0;
        residual[2] = p[2] + 2.0;
        return true;
    }
};
/// 5 + p0^2 / 2 along the valley of Bent: far from 0, and itself curved.
struct High {
    template <typename T>
    bool operator()(const T* p, T* residual) const {
        residual[0] = 5.0 + 0.5 * p[0] * p[0];
        return true;
    }
};
/// Half its square has a top at 0, where its slope is none, and lowest places at +-sqrt(4.5).
struct Top {
    template <typename T>
    bool operator()(const T* x, T* residual) const {
        residual[0] = x[0];
        residual[1] = x[0] * x[0] - 5.0;
        return true;
    }
};

class Valley : public testing::Test {
  protected:
    Valley() {
        problem_.AddParameterBlock(shared_.data(), 3);
        problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<Bent, 3, 3>(new Bent), nullptr,
                                  shared_.data());
        for (std::size_t i = 0; i < 2; ++i)
            problem_.AddResidualBlock(
                new ceres::AutoDiffCostFunction<Follows, 1, 3, 1>(new Follows{double(i) + 0.5}),
                nullptr, shared_.data(), &poses_[i]);
    }
    std::vector<double*> poses() { return {&poses_[0], &poses_[1]}; }

    std::array<double, 3> shared_{-2, 4, 1};
    std::array<double, 2> poses_{6, 10};
    ceres::Problem problem_;
};

TEST_F(Valley, IsFollowedToItsLowestPlace) {
    const SolveEnd end = valley_solve(problem_, {shared_.data()}, poses(), 30);
    EXPECT_TRUE(end.converged);
    EXPECT_LT(end.iterations, 15);
    EXPECT_NEAR(end.final_cost, 0, 1e-3);
    EXPECT_NEAR(shared_[0], 3, 0.05);
    EXPECT_NEAR(shared_[1], 9, 0.3);
    EXPECT_NEAR(shared_[2], -2, 0.05);
    EXPECT_NEAR(poses_[0], 0.5 * shared_[0] * shared_[0] + shared_[1], 1e-3);
    EXPECT_NEAR(poses_[1], 1.5 * shared_[0] * shared_[0] + shared_[1], 1e-3);
}

TEST_F(Valley, MakesDampedStepsCreep) {
    ceres::Solver::Options options;
    options.max_num_iterations = 30;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    EXPECT_GT(summary.final_cost, 1);
}

TEST_F(Valley, IsFollowedWhereTheResidualsThemselvesCurve) {
    problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<High, 1, 3>(new High), nullptr,
                              shared_.data());
    const SolveEnd end = valley_solve(problem_, {shared_.data()}, poses(), 30);
    EXPECT_TRUE(end.converged);
    EXPECT_LT(end.iterations, 15);
    // (x - 3) + (5 + x^2 / 2) x = 0 along the valley.
    EXPECT_NEAR(shared_[0], 0.4949, 0.03);
}

TEST_F(Valley, LeavesHeldBlocksAndEntries) {
    shared_ = {-2.5, 6.25, 7};
    problem_.SetManifold(shared_.data(), new ceres::SubsetManifold(3, {2}));
    problem_.SetParameterBlockConstant(&poses_[1]);
    const SolveEnd end = valley_solve(problem_, {shared_.data()}, poses(), 30);
    EXPECT_TRUE(end.converged);
    EXPECT_EQ(shared_[2], 7);
    EXPECT_EQ(poses_[1], 10);
    EXPECT_NEAR(1.5 * shared_[0] * shared_[0] + shared_[1], 10, 1e-3);  // the held pose's word
}

/// Solves Top from beside it; x becomes where it ends.
SolveEnd leave_top(double& x, int most_iterations) {
    x = 1e-9;
    ceres::Problem problem;
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Top, 2, 1>(new Top), nullptr, &x);
    return valley_solve(problem, {&x}, {}, most_iterations);
}

TEST(ValleySolve, LeavesATop) {
    double x = 0;
    const SolveEnd end = leave_top(x, 30);
    EXPECT_TRUE(end.converged);
    EXPECT_NEAR(std::abs(x), std::sqrt(4.5), 0.02);
    EXPECT_NEAR(end.final_cost, 0.5 * (4.5 + 0.25), 1e-3);
}

TEST(ValleySolve, StopsWhereItIsTold) {
    double x = 0;
    const SolveEnd end = leave_top(x, 1);
    EXPECT_FALSE(end.converged);
    EXPECT_EQ(end.iterations, 1);
    EXPECT_LT(end.final_cost, end.initial_cost);
}

/// Against the dense normal equations.
TEST_F(Valley, HasTheArrowsSolution) {
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = {shared_.data(), &poses_[0], &poses_[1]};
    ceres::CRSMatrix jacobian;
    problem_.Evaluate(options, nullptr, nullptr, nullptr, &jacobian);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(jacobian.num_rows, jacobian.num_cols);
    for (int row = 0; row < jacobian.num_rows; ++row)
        for (int i = jacobian.rows[row]; i < jacobian.rows[row + 1]; ++i)
            dense(row, jacobian.cols[i]) = jacobian.values[i];
    const Eigen::MatrixXd normal = dense.transpose() * dense;
    const ArrowSystem system(problem_, {shared_.data()}, {&poses_[0], &poses_[1]}, jacobian);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(5, -1, 2);
    EXPECT_LT((system.solve(normal * x) - x).norm(), 1e-5);
    const Eigen::MatrixXd weak = system.weakest(2);
    EXPECT_LT((weak.transpose() * normal * weak - Eigen::Matrix2d::Identity()).norm(), 1e-6);
}

}  // namespace
}  // namespace stria

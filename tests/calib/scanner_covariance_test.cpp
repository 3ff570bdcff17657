#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <iostream>

#include "tests/calib/linearised_calibration.h"

namespace stria {
namespace {

class CovarianceOf : public testing::TestWithParam<MachineKind> {};

/// The covariance of the joint problem against one from central differences of host/core's
/// functions, in perturbed()'s parameters: what each claims for any combination of parameters
/// differs by less than 1 %, and errors of re-simulated calibrations have its chi-square.
TEST_P(CovarianceOf, AgreesWithDifferencesAndResimulation) {
    const Board board = parse_board("chessboard:9x6:30");
    const ScannerModel drawn = drawn_scanner(GetParam());
    std::mt19937 rng(41);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions views_options;
    views_options.views = 6;
    views_options.pictures = GetParam() == MachineKind::swept ? 1 : 3;
    views_options.pixel_step = 32;
    views_options.frames = 30;
    views_options.noisy = false;
    std::vector<Rigid3> poses;
    const auto views = synthetic_views(truth, board, views_options, rng, &poses);
    ScannerCalibrationOptions options = options_of_built_scanners();
    options.stripe_points_per_view = 60;
    ScannerProblem problem = problem_at_truth(truth, board, views, poses, 0.05, options);
    const LinearisedCalibration oracle(truth, board, problem, options);
    const Eigen::MatrixXd claimed = problem.covariance()(oracle.free(), oracle.free());

    const Eigen::LLT<Eigen::MatrixXd> root(oracle.covariance());
    const Eigen::MatrixXd inside =
        root.matrixL().solve(root.matrixL().solve(claimed).transpose().eval());
    EXPECT_LT((inside - Eigen::MatrixXd::Identity(inside.rows(), inside.cols())).norm(), 0.01);

    constexpr int kTrials = 100;
    double chi_square = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        const Eigen::VectorXd error = oracle.errors_of_a_trial(rng);
        chi_square += error.dot(claimed.ldlt().solve(error));
    }
    const double dof = kTrials * static_cast<double>(claimed.rows());
    std::cout << name_of(GetParam()) << ": chi-square per degree of freedom " << chi_square / dof
              << " of " << dof << std::endl;
    EXPECT_NEAR(chi_square / dof, 1, 4 * std::sqrt(2 / dof));
}

INSTANTIATE_TEST_SUITE_P(Machines, CovarianceOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

}  // namespace
}  // namespace stria

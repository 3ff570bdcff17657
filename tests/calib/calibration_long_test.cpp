#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>

#include "calib/scanner_calibration.h"
#include "host/geometry/align.h"
#include "tests/calib/linearised_calibration.h"
#include "tests/calib/point_scale.h"
#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

constexpr int kSeeds = 20;
constexpr int kStripePoints = 1000;  ///< a view, the default
constexpr double kGoalRms = 2e-5;    ///< of the volume's diagonal, after the best rigid motion
constexpr double kGoalMax = 1e-4;
constexpr double kGoalAxisDeg = 0.003;
constexpr double kGoalAxisMm = 0.02;

SyntheticOptions forty_views(MachineKind kind) {
    SyntheticOptions options;
    options.views = 40;
    options.pictures = kind == MachineKind::swept ? 1 : 5;
    options.max_tilt_rad = 0.611;  // 35 deg
    options.turn_rad = 2.0944;     // 120 deg
    options.pixel_step = 16;
    options.frames = 80;
    return options;
}

class FortyViewsOf : public testing::TestWithParam<MachineKind> {};

/// 40 views of a 12 x 9 board, corners 0.05 px, stripes 0.1 px, a machine anew in each seed.
TEST_P(FortyViewsOf, ReachTheGoalAndThePrediction) {
    const Board board = parse_board("chessboard:12x9:22");
    const ScannerModel drawn = drawn_scanner(GetParam());
    double error_squares = 0, predicted_squares = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        std::mt19937 rng(static_cast<unsigned>(seed));
        const ScannerModel truth = built_scanner(drawn, rng);
        const auto views = synthetic_views(truth, board, forty_views(GetParam()), rng);
        const auto voxels = volume_voxels(truth, views);
        const auto start = std::chrono::steady_clock::now();
        const ScannerCalibration found =
            calibrate_scanner(views, board, drawn, {.stripe_points_per_view = kStripePoints});
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const PointError error = point_error(truth, found.model, voxels);
        const PredictedSigma predicted = predict_sigma(found.model, voxels);
        error_squares += error.rms_mm * error.rms_mm / kSeeds;
        predicted_squares += predicted.rms_mm * predicted.rms_mm / kSeeds;
        std::cout << name_of(GetParam()) << " seed " << seed << ": rms "
                  << error.rms_mm / error.diagonal_mm << " of " << error.diagonal_mm << " mm, max "
                  << error.max_mm / error.diagonal_mm << ", predicted rms "
                  << predicted.rms_mm / error.diagonal_mm << ", axis " << error.axis_deg << " deg "
                  << error.axis_mm << " mm, corners " << found.corner_sigma_px << " px, stripes "
                  << found.stripe_sigma_factor << ", " << voxels.size() << " voxels, " << seconds
                  << " s" << std::endl;
        EXPECT_TRUE(found.converged);
        EXPECT_LE(error.rms_mm / error.diagonal_mm, kGoalRms);
        EXPECT_LE(error.max_mm / error.diagonal_mm, kGoalMax);
        EXPECT_LE(error.axis_deg, kGoalAxisDeg);
        EXPECT_LE(error.axis_mm, kGoalAxisMm);
    }
    const double ratio = std::sqrt(error_squares / predicted_squares);
    std::cout << name_of(GetParam()) << ": rms over the seeds / predicted " << ratio << std::endl;
    EXPECT_LE(ratio, 1.1);
}

/// Two lasers on one camera, solved together, see one size.
TEST_P(FortyViewsOf, GiveTwoLasersOneSize) {
    const Board board = parse_board("chessboard:12x9:22");
    const ScannerModel drawn = drawn_with_two_lasers(GetParam());
    for (unsigned seed = 1; seed <= 3; ++seed) {
        std::mt19937 rng(seed);
        const ScannerModel truth = built_scanner(drawn, rng);
        const auto views = synthetic_views(truth, board, forty_views(GetParam()), rng);
        const auto found =
            calibrate_scanner(views, board, drawn, {.stripe_points_per_view = kStripePoints});
        const auto voxels = volume_voxels(truth, views);
        const double difference =
            scale_of(truth, found.model, voxels, 0) - scale_of(truth, found.model, voxels, 1);
        std::cout << name_of(GetParam()) << " seed " << seed << ": two lasers' scales differ by "
                  << difference << std::endl;
        EXPECT_LE(std::abs(difference), 3e-5);
    }
}

/// How voxels move with the free parameters, the rigid motion common to them taken out: 3 rows
/// each.
Eigen::MatrixXd response_of(const ScannerModel& truth, const std::vector<VolumeSample>& voxels,
                            const std::vector<Eigen::Index>& free) {
    const auto points_of = [&](const ScannerModel& model) {
        std::vector<Eigen::Vector3d> points;
        for (const VolumeSample& voxel : voxels)
            points.push_back(
                triangulate(model.channels[0], voxel.pixel, voxel.s).value().point_in_scan);
        return points;
    };
    const auto right = points_of(truth);
    const Eigen::VectorXd sigma = building_sigma(truth);
    Eigen::MatrixXd response(3 * Eigen::Index(voxels.size()), Eigen::Index(free.size()));
    for (std::size_t k = 0; k < free.size(); ++k) {
        Eigen::VectorXd delta = Eigen::VectorXd::Zero(sigma.size());
        delta[free[k]] = 1e-4 * sigma[free[k]];
        const auto moved = points_of(perturbed(truth, delta));
        const Rigid3 motion = align_points(moved, right);
        for (std::size_t i = 0; i < right.size(); ++i)
            response.block<3, 1>(3 * Eigen::Index(i), Eigen::Index(k)) =
                (motion * moved[i] - right[i]) / delta[free[k]];
    }
    return response;
}

/// Of predicted over actual sigma, voxel by voxel.
void expect_honest(const char* what, std::vector<double> ratios) {
    std::sort(ratios.begin(), ratios.end());
    const auto inside =
        std::count_if(ratios.begin(), ratios.end(), [](double r) { return r >= 0.9 && r <= 1.1; });
    const double share = static_cast<double>(inside) / static_cast<double>(ratios.size());
    std::cout << what << ": predicted / actual sigma " << ratios[ratios.size() / 40] << " .. "
              << ratios[ratios.size() / 2] << " .. " << ratios[ratios.size() * 39 / 40]
              << " (95 % of " << ratios.size() << " voxels), within [0.9, 1.1]: " << share
              << std::endl;
    EXPECT_GE(share, 0.95) << what;
}

class ResimulationOf : public testing::TestWithParam<MachineKind> {};

/// 1000 calibrations linearised once at the truth, and 50 full ones, each with fresh noise and a
/// drawing anew around the machine.
TEST_P(ResimulationOf, ShowsTheSigmaThatWasPredicted) {
    const Board board = parse_board("chessboard:12x9:22");
    std::mt19937 rng(61);
    const ScannerModel truth = built_scanner(drawn_scanner(GetParam()), rng);
    SyntheticOptions synthetic = forty_views(GetParam());
    synthetic.views = 20;
    synthetic.pictures = std::min(synthetic.pictures, 3);
    synthetic.noisy = false;
    std::vector<Rigid3> poses;
    const auto views = synthetic_views(truth, board, synthetic, rng, &poses);
    const auto voxels = volume_voxels(truth, views);
    ScannerCalibrationOptions options = options_of_built_scanners();
    options.stripe_points_per_view = kStripePoints;
    ScannerProblem problem = problem_at_truth(truth, board, views, poses, 0.05, options);
    const LinearisedCalibration linear(truth, board, problem, options);
    const Eigen::MatrixXd response = response_of(truth, voxels, linear.free());
    const Eigen::MatrixXd claimed = problem.covariance()(linear.free(), linear.free());

    constexpr int kLinearised = 1000, kFull = 50;
    double parameter_chi_square = 0;
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(Eigen::Index(voxels.size()));
    const Eigen::LDLT<Eigen::MatrixXd> inverse(claimed);
    for (int trial = 0; trial < kLinearised; ++trial) {
        const Eigen::VectorXd error = linear.errors_of_a_trial(rng);
        parameter_chi_square += error.dot(inverse.solve(error));
        const Eigen::VectorXd moved = response * error;
        for (Eigen::Index i = 0; i < squares.size(); ++i)
            squares[i] += moved.segment<3>(3 * i).squaredNorm() / kLinearised;
    }
    parameter_chi_square /= kLinearised * static_cast<double>(claimed.rows());
    std::cout << name_of(GetParam()) << ": chi-square of the parameters per degree of freedom "
              << parameter_chi_square << std::endl;
    EXPECT_GE(parameter_chi_square, 0.95);
    EXPECT_LE(parameter_chi_square, 1.05);

    Eigen::VectorXd full = Eigen::VectorXd::Zero(squares.size()), predicted = full;
    double chi_square = 0;
    for (int trial = 0; trial < kFull; ++trial) {
        const ScannerModel drawing = built_scanner(truth, rng);
        const auto found = calibrate_scanner(with_noise(views, 0.05, rng), board, drawing, options);
        EXPECT_TRUE(found.converged);
        std::vector<Eigen::Vector3d> right, ours;
        for (const VolumeSample& voxel : voxels) {
            right.push_back(
                triangulate(truth.channels[0], voxel.pixel, voxel.s).value().point_in_scan);
            ours.push_back(
                triangulate(found.model.channels[0], voxel.pixel, voxel.s).value().point_in_scan);
        }
        const Rigid3 motion = align_points(ours, right);
        const auto covariances = predict_covariance(found.model, voxels);
        for (std::size_t i = 0; i < voxels.size(); ++i) {
            const auto at = static_cast<Eigen::Index>(i);
            full[at] += (motion * ours[i] - right[i]).squaredNorm() / kFull;
            predicted[at] += covariances[i].trace() / kFull;
        }
        const double corners = found.corner_sigma_px / 0.05, stripes = found.stripe_sigma_factor;
        chi_square += 0.5 * (corners * corners + stripes * stripes) / kFull;
    }
    std::vector<double> against_linear, against_full;
    for (Eigen::Index i = 0; i < squares.size(); ++i) {
        against_linear.push_back(std::sqrt(predicted[i] / squares[i]));
        against_full.push_back(std::sqrt(predicted[i] / full[i]));
    }
    expect_honest("1000 linearised", against_linear);
    // 50 trials know a sigma to 6 to 10 %: their median over the voxels, which move together, lies
    // within 25 % (3 standard deviations).
    std::sort(against_full.begin(), against_full.end());
    const double middle = against_full[against_full.size() / 2];
    std::cout << "50 full: predicted / actual sigma " << against_full.front() << " .. " << middle
              << " .. " << against_full.back() << ", chi-square of the residuals " << chi_square
              << std::endl;
    EXPECT_NEAR(middle, 1, 0.25);
    EXPECT_GE(chi_square, 0.95);
    EXPECT_LE(chi_square, 1.05);
}

INSTANTIATE_TEST_SUITE_P(Machines, ResimulationOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

INSTANTIATE_TEST_SUITE_P(Machines, FortyViewsOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

}  // namespace
}  // namespace stria

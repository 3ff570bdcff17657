#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <iostream>

#include "calib/certify.h"
#include "tests/calib/synthetic_scanner.h"

/// Scanners calibrated from corners of which neighbours err alike, as those of real pictures do:
/// what the calibration expects of itself must hold all the same.
namespace stria {
namespace {

constexpr double kSigmaPx = 0.05, kShared = 0.6, kReachPitches = 3;

/// Adds errors with the covariance of CornerNoise, written out again, to every picture.
void add_shared_errors(std::vector<CornerView>& views, const Board& board, std::mt19937& rng) {
    std::normal_distribution<double> unit(0, 1);
    const auto points = board_points(board);
    for (CornerView& view : views)
        for (BoardCorners& seen : view.corners) {
            const auto count = static_cast<Eigen::Index>(seen.ids.size());
            Eigen::MatrixXd covariance(count, count), white(count, 2);
            const auto at = [&](Eigen::Index i) {
                return points[static_cast<std::size_t>(seen.ids[static_cast<std::size_t>(i)])];
            };
            for (Eigen::Index i = 0; i < count; ++i)
                for (Eigen::Index j = 0; j < count; ++j)
                    covariance(i, j) = kSigmaPx * kSigmaPx *
                                       ((i == j ? 1 - kShared : 0) +
                                        kShared * std::exp(-(at(i) - at(j)).norm() /
                                                           board.pitch_mm / kReachPitches));
            for (double& value : white.reshaped()) value = unit(rng);
            const Eigen::MatrixXd errors =
                Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL() * white;
            for (Eigen::Index i = 0; i < count; ++i)
                seen.pixels[static_cast<std::size_t>(i)] += errors.row(i).transpose();
        }
}

/// What came of a few calibrations, over what they expected.
struct Judged {
    double squares = 0, predicted = 0;           ///< of point errors
    double chi_square = 0, degrees = 0;          ///< of halves
    double held_out_p = 0;                       ///< sum
    double trueness = 0, expected_trueness = 0;  ///< squares
    int failed = 0;

    void add(const ScannerModel& truth, const ScannerCalibration& found, const Board& board,
             const std::vector<CornerView>& views, const std::vector<CornerView>& held_out) {
        const auto voxels = volume_voxels(truth, views);
        squares += std::pow(point_error(truth, found.model, voxels).rms_mm, 2);
        predicted += std::pow(predict_sigma(found.model, voxels).rms_mm, 2);
        const CrossValidation halves = cross_validate(views, board, found, 100);
        for (const SplitCheck& split : halves.splits) {
            chi_square += split.chi_square;
            degrees += split.degrees;
        }
        const HeldOutCheck check = check_held_out(held_out, board, found);
        held_out_p += check.p_value;
        trueness += check.trueness_mm * check.trueness_mm;
        expected_trueness += check.expected_trueness_mm * check.expected_trueness_mm;
        failed += certify(found, check, halves).status == CertificateStatus::failed;
    }
    void print(const char* what, int trials) const {
        std::cout << what << ": points " << std::sqrt(squares / predicted)
                  << " of predicted, halves' chi-square " << chi_square / degrees
                  << " a degree of freedom, held out p " << held_out_p / trials
                  << " on average, trueness " << std::sqrt(trueness / expected_trueness)
                  << " of expected, " << failed << " of " << trials << " failed" << std::endl;
    }
};

class SharedCornersOf : public testing::TestWithParam<MachineKind> {};

TEST_P(SharedCornersOf, WhatIsExpectedHolds) {
    constexpr int kTrials = STRIA_SHARED_TRIALS;
    const Board board = parse_board("chessboard:12x9:22");
    const ScannerModel drawn = drawn_scanner(GetParam());
    ScannerCalibrationOptions quick = options_of_built_scanners();
    quick.stripe_points_per_view = 100;
    Judged judged, as_if_independent;
    for (unsigned seed = 0; seed < kTrials; ++seed) {
        std::mt19937 rng(700 + seed);
        const ScannerModel truth = built_scanner(drawn, rng);
        SyntheticOptions options;
        options.views = 16;
        options.pixel_step = 24;
        options.frames = 40;
        options.corner_noise_px = 1e-9;
        if (GetParam() != MachineKind::swept) options.pictures = 3;
        std::vector<CornerView> views, held_out, all = synthetic_views(truth, board, options, rng);
        add_shared_errors(all, board, rng);
        for (std::size_t i = 0; i < all.size(); ++i)
            (i % 4 == 2 ? held_out : views).push_back(std::move(all[i]));
        ScannerCalibration found = calibrate_scanner(views, board, drawn, quick);
        EXPECT_TRUE(found.corner_noise.refutes_independence()) << seed;
        judged.add(truth, found, board, views, held_out);
        found.corner_noise = CornerNoise{found.corner_sigma_px};
        as_if_independent.add(truth, found, board, views, held_out);
    }
    judged.print(name_of(GetParam()), kTrials);
    as_if_independent.print("  halves and held-out views as if independent", kTrials);
    // Three standard deviations each: some four directions make up most of a point error; a trial's
    // two splits have about 36 degrees of freedom and share their views; p is uniform.
    EXPECT_NEAR(std::sqrt(judged.squares / judged.predicted), 1, 3 / std::sqrt(8.0 * kTrials));
    EXPECT_NEAR(std::sqrt(judged.trueness / judged.expected_trueness), 1,
                3 / std::sqrt(8.0 * kTrials));
    const double tolerance = 3 * std::sqrt(2.0 * 2 / (36 * kTrials));
    EXPECT_NEAR(judged.chi_square / judged.degrees, 1, tolerance);
    EXPECT_NEAR(judged.held_out_p / kTrials, 0.5, 3 * 0.289 / std::sqrt(kTrials));
    EXPECT_LE(judged.failed, kTrials / 10);
    EXPECT_GT(as_if_independent.chi_square / as_if_independent.degrees, 1 + tolerance);
}

INSTANTIATE_TEST_SUITE_P(Machines, SharedCornersOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

}  // namespace
}  // namespace stria

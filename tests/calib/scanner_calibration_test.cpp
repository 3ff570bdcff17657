#include "calib/scanner_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>

#include "host/core/errors.h"
#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

const char* const kBoard = "chessboard:12x9:22";

SyntheticOptions usual_views(MachineKind kind) {
    SyntheticOptions options;
    if (kind != MachineKind::swept) options.pictures = 5;
    return options;
}

class ScannerCalibrationOf : public testing::TestWithParam<MachineKind> {};

TEST_P(ScannerCalibrationOf, MeetsThePointErrorAndItsOwnPrediction) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    double ratio_squares = 0;
    std::vector<double> shares;
    const int seeds = STRIA_SEEDS;
    for (int seed = 1; seed <= seeds; ++seed) {
        std::mt19937 rng(static_cast<unsigned>(seed));
        const ScannerModel truth = built_scanner(drawn, rng);
        const auto views = synthetic_views(truth, board, usual_views(GetParam()), rng);
        const auto start = std::chrono::steady_clock::now();
        const ScannerCalibration found = calibrate_scanner(views, board, drawn);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const PointError error = point_error(truth, found.model, views);
        const double share = error.rms_mm / error.diagonal_mm;
        shares.push_back(share);
        const double ratio = error.rms_mm / found.predicted.rms_mm;
        ratio_squares += ratio * ratio / seeds;
        std::cout << name_of(GetParam()) << " seed " << seed << ": rms " << error.rms_mm
                  << " mm = " << share << " of " << error.diagonal_mm << " mm, max "
                  << error.max_mm / error.diagonal_mm << ", predicted " << found.predicted.rms_mm
                  << " (median " << found.predicted.median_mm << "), corners " << found.rms_px
                  << " px, stripe factor " << found.stripe_sigma_factor << ", chi2/dof "
                  << found.chi_square_per_dof << ", " << seconds << " s" << std::endl;
        EXPECT_TRUE(found.converged);
        EXPECT_EQ(found.views_used, 15);
        EXPECT_NEAR(found.corner_sigma_px, 0.05, 0.004);
        EXPECT_NEAR(found.stripe_sigma_factor, 1.0, 0.05);
        EXPECT_EQ(validate(found.model), "");
        for (const auto& warning : found.warnings) ADD_FAILURE() << warning;
        EXPECT_LE(share, 1e-4) << "of the diagonal";
    }
    std::sort(shares.begin(), shares.end());
    EXPECT_LE(shares[seeds / 2], 2e-5);
    // The predicted rms holds as a distribution: few degrees of freedom dominate each trial, so one
    // ratio lies within a factor of 3, and the root mean square over 6 seeds within 1.6.
    EXPECT_GT(ratio_squares, seeds < 6 ? 1 / 9.0 : 1 / 2.6);
    EXPECT_LT(ratio_squares, seeds < 6 ? 9.0 : 2.6);
}

#if STRIA_SEEDS == 1  // the program of many seeds runs the test above alone
TEST(ScannerCalibration, SurvivesStrayPulses) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(MachineKind::rail);
    std::mt19937 rng(21);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions options = usual_views(MachineKind::rail);
    options.outlier_share = 0.1;
    options.views = 8;
    const auto views = synthetic_views(truth, board, options, rng);
    const ScannerCalibration found = calibrate_scanner(views, board, drawn);
    const PointError error = point_error(
        truth, found.model, synthetic_views(truth, board, usual_views(MachineKind::rail), rng));
    EXPECT_LE(error.rms_mm / error.diagonal_mm, 1e-4);
    EXPECT_NEAR(found.stripe_sigma_factor, 1.0, 0.1);
    int rejected = 0;
    for (const auto& view : found.views) rejected += view.stripe_points_rejected;
    EXPECT_GT(rejected, 100);
}

TEST(ScannerCalibration, SaysWhatIsMissing) {
    const ScannerModel drawn = drawn_scanner(MachineKind::rail);
    const Board board = parse_board(kBoard);
    std::mt19937 rng(2);
    SyntheticOptions options = usual_views(MachineKind::rail);
    options.views = 5;
    auto views = synthetic_views(drawn, board, options, rng);
    EXPECT_THROW(calibrate_scanner(views, parse_board("chessboard:11x9:22"), drawn), Error);
    EXPECT_THROW(
        calibrate_scanner(std::vector<CornerView>(views.begin(), views.begin() + 2), board, drawn),
        Error);
    for (auto& view : views) view.pulses = PulseMap{};
    try {
        calibrate_scanner(views, board, drawn);
        FAIL() << "no stripe at all was accepted";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("stripe"), std::string::npos) << error.what();
    }
}

TEST(ScannerCalibration, WarnsOfParallelBoards) {
    const ScannerModel drawn = drawn_scanner(MachineKind::rail);
    const Board board = parse_board(kBoard);
    std::mt19937 rng(3);
    SyntheticOptions options = usual_views(MachineKind::rail);
    options.views = 6;
    options.max_tilt_rad = 0.05;
    const auto found = calibrate_scanner(synthetic_views(drawn, board, options, rng), board, drawn);
    bool named = false;
    for (const auto& warning : found.warnings)
        named = named || warning.find("nearly parallel") != std::string::npos;
    EXPECT_TRUE(named);
}

INSTANTIATE_TEST_SUITE_P(Machines, ScannerCalibrationOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });
#else
INSTANTIATE_TEST_SUITE_P(ManySeeds, ScannerCalibrationOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });
#endif

}  // namespace
}  // namespace stria

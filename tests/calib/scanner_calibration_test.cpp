#include "calib/scanner_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <stdexcept>

#include "host/core/errors.h"
#include "tests/calib/point_scale.h"
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

/// One seed; calibration_long_test holds 20 of them to the goals.
TEST_P(ScannerCalibrationOf, MeetsThePointErrorAndItsOwnPrediction) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    std::mt19937 rng(1);
    const ScannerModel truth = built_scanner(drawn, rng);
    const auto views = synthetic_views(truth, board, usual_views(GetParam()), rng);
    const ScannerCalibration found = calibrate_scanner(views, board, drawn);
    const auto voxels = volume_voxels(truth, views);
    const PointError error = point_error(truth, found.model, voxels);
    const double predicted_mm = predict_sigma(found.model, voxels).rms_mm;
    std::cout << name_of(GetParam()) << ": rms " << error.rms_mm / error.diagonal_mm << " of "
              << error.diagonal_mm << " mm, max " << error.max_mm / error.diagonal_mm
              << ", predicted rms " << predicted_mm / error.diagonal_mm << ", axis "
              << error.axis_deg << " deg " << error.axis_mm << " mm" << std::endl;
    EXPECT_TRUE(found.converged);
    EXPECT_EQ(found.views_used, 15);
    EXPECT_NEAR(found.corner_sigma_px, 0.05, 0.004);
    EXPECT_NEAR(found.stripe_sigma_factor, 1.0, 0.05);
    EXPECT_EQ(validate(found.model), "");
    for (const auto& warning : found.warnings) ADD_FAILURE() << warning;
    EXPECT_LE(error.rms_mm / error.diagonal_mm, 1e-4);
    // Few degrees of freedom dominate a trial, so that one ratio lies within a factor of 3.
    EXPECT_GT(error.rms_mm / predicted_mm, 1 / 3.0);
    EXPECT_LT(error.rms_mm / predicted_mm, 3.0);
}

/// calibration_long_test does so for the other machines, with 40 views.
TEST(ScannerCalibration, GivesTwoLasersOneSize) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_with_two_lasers(MachineKind::turntable);
    std::mt19937 rng(5);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions options = usual_views(MachineKind::turntable);
    options.pixel_step = 16;
    options.frames = 60;
    const auto views = synthetic_views(truth, board, options, rng);
    const ScannerCalibration found =
        calibrate_scanner(views, board, drawn, {.stripe_points_per_view = 200});
    const auto voxels = volume_voxels(truth, views);
    const PointError error = point_error(truth, found.model, voxels);
    const double difference =
        scale_of(truth, found.model, voxels, 0) - scale_of(truth, found.model, voxels, 1);
    std::cout << "scales differ by " << difference << ", both lasers rms "
              << error.rms_mm / error.diagonal_mm << ", predicted "
              << predict_sigma(found.model, voxels).rms_mm / error.diagonal_mm << std::endl;
    EXPECT_TRUE(found.converged);
    EXPECT_EQ(found.model.channels.size(), 2U);
    EXPECT_EQ(validate(found.model), "");
    EXPECT_LE(std::abs(difference), 3e-5);
    EXPECT_LE(error.rms_mm / error.diagonal_mm, 1e-4);
}

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

/// A machine and views from whose start one long step would turn the mirror by 84 deg, its sheet
/// following, into a false solution with a sheet that is bent the wrong way.
TEST(ScannerCalibration, KeepsTheMirrorOnItsSide) {
    const Board board = parse_board("chessboard:12x9:22");
    const ScannerModel drawn = drawn_scanner(MachineKind::swept);
    std::mt19937 rng(8);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions options;
    options.views = 40;
    options.max_tilt_rad = 0.611;
    options.turn_rad = 2.0944;
    options.pixel_step = 16;
    options.frames = 80;
    const auto views = synthetic_views(truth, board, options, rng);
    const ScannerCalibration found =
        calibrate_scanner(views, board, drawn, {.stripe_points_per_view = 200});
    const Eigen::Vector3d& right = truth.channels[0].axis.mirror.normal0;
    EXPECT_TRUE(found.converged);
    EXPECT_LT(std::acos(found.model.channels[0].axis.mirror.normal0.dot(right)), 0.1);
    EXPECT_NEAR(found.model.channels[0].sheet.bow3, truth.channels[0].sheet.bow3, 2e-3);
}

TEST(ScannerCalibration, SaysThatAMirrorIsNotTheDrawnOne) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(MachineKind::swept);
    std::mt19937 rng(9);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions options = usual_views(MachineKind::swept);
    options.views = 6;
    options.pixel_step = 24;
    const auto views = synthetic_views(truth, board, options, rng);
    ScannerCalibrationOptions solve{.stripe_points_per_view = 100};
    solve.nominal_angle_sigma_rad = 1e-3;  // claims a better drawing than it is
    const ScannerCalibration found = calibrate_scanner(views, board, drawn, solve);
    EXPECT_FALSE(found.converged);
    EXPECT_TRUE(std::any_of(found.warnings.begin(), found.warnings.end(), [](const std::string& w) {
        return w.find("deg from its drawing") != w.npos;
    }));
}

TEST(ScannerCalibration, RefusesChannelsThatShareNoCameraOrAxis) {
    const Board board = parse_board(kBoard);
    const auto says = [&](const ScannerModel& nominal, const std::string& part) {
        try {
            calibrate_scanner(std::vector<CornerView>{}, board, nominal);
            ADD_FAILURE() << "accepted: " << part;
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    };
    const ScannerModel two = drawn_with_two_lasers(MachineKind::rail);
    ScannerModel other = two;
    other.channels[1].camera_id = 1;
    says(other, "channel 1 has camera 1");
    other = two;
    other.channels[1].axis.kind = MachineKind::swept;
    says(other, "channel 1 has axis kind swept");
    other = two;
    other.channels[1].laser_id = 0;
    says(other, "channel 1 has laser 0");
}

/// 3 ms at 20 mm/s are 60 um along the rail. The boards' tilt alone shows them: a board square to
/// the view looks the same wherever the rail is.
TEST(ScannerCalibration, FindsTheClocksDelayFromTwoDirections) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(MachineKind::rail);
    std::mt19937 rng(8);
    ScannerModel truth = built_scanner(drawn, rng);
    truth.channels[0].axis.delay_ns = 3e6;
    SyntheticOptions options = usual_views(MachineKind::rail);
    options.views = 8;
    options.pixel_step = 16;
    options.frames = 60;
    options.both_directions = true;
    const auto found = calibrate_scanner(synthetic_views(truth, board, options, rng), board, drawn,
                                         {.stripe_points_per_view = 200});
    const auto names = parameter_names(found.model);
    const auto delay = std::find(names.begin(), names.end(), "channel0.axis.delay") - names.begin();
    const double sigma_ns = std::sqrt(found.model.covariance(delay, delay));
    std::cout << "delay " << found.model.channels[0].axis.delay_ns << " ns of 3e6, sigma "
              << sigma_ns << std::endl;
    EXPECT_GT(sigma_ns, 0);
    EXPECT_GT(found.model.channels[0].axis.delay_ns, 4 * sigma_ns) << "not told from 0";
    EXPECT_LT(std::abs(found.model.channels[0].axis.delay_ns - 3e6), 4 * sigma_ns);
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
}  // namespace
}  // namespace stria

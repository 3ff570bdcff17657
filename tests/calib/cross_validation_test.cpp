#include "calib/cross_validation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include "calib/projected_view.h"
#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

constexpr double kLeftPx = 0.1;  ///< rms of an injected error after the best refit

ScannerCalibrationOptions quick() { return {.stripe_points_per_view = 100}; }

/// A machine, and views by it.
struct Trial {
    Trial(MachineKind kind, unsigned seed)
        : rng(seed), drawn(drawn_scanner(kind)), truth(built_scanner(drawn, rng)) {
        options.views = 12;
        options.pixel_step = 24;
        options.frames = 40;
        if (kind != MachineKind::swept) options.pictures = 3;
        views = synthetic_views(truth, board, options, rng);
    }
    CrossValidation judge() const {
        return cross_validate(views, board, calibrate_scanner(views, board, drawn, quick()), 100);
    }

    std::mt19937 rng;
    Board board = parse_board("chessboard:12x9:22");
    ScannerModel drawn, truth;
    SyntheticOptions options;
    std::vector<CornerView> views;
};

/// Where light that should arrive at a pixel arrives instead, in px, for amplitude 1: errors that
/// no parameter of the model describes.
class ModelError {
  public:
    ModelError(int kind, const CameraModel& camera, MachineKind machine, std::mt19937& rng)
        : kind_(kind), camera_(camera) {
        std::uniform_real_distribution<double> unit(0, 1);
        phase_ = 2 * std::numbers::pi * unit(rng);
        angle_ = 2 * std::numbers::pi * unit(rng);
        wave_px_ = 300 + 300 * unit(rng);
        travel_ = machine == MachineKind::rail ? 240 : machine == MachineKind::swept ? 0.3 : 1.4;
        turns_ = 2 + 2 * unit(rng);
    }
    bool is_of_the_sheet() const { return kind_ >= 3; }

    Eigen::Vector2d at(const Eigen::Vector2d& pixel, double s, bool stripe) const {
        const Eigen::Vector2d from_centre(pixel.x() - camera_.cx, pixel.y() - camera_.cy);
        const double r = from_centre.norm() / 800;
        const Eigen::Vector2d along(std::cos(angle_), std::sin(angle_));
        switch (kind_) {
            case 0:  // a ripple of the lens's radial distortion
                return std::cos(2 * std::numbers::pi * 800 * r / wave_px_ + phase_) *
                       from_centre.normalized();
            case 1:  // a wavy sensor or window
                return std::sin(2 * std::numbers::pi * along.dot(from_centre) / wave_px_ + phase_) *
                       Eigen::Vector2d(-along.y(), along.x());
            case 2:  // a lens out of round
                return r * r * std::cos(3 * std::atan2(from_centre.y(), from_centre.x()) + phase_) *
                       from_centre / 800;
            case 3:  // the sheet bent along its fan, beyond two powers
                return Eigen::Vector2d(
                    stripe ? std::sin(2 * std::numbers::pi * pixel.y() / wave_px_ + phase_) : 0, 0);
            default:  // the axis runs unevenly
                return Eigen::Vector2d(
                    stripe ? std::sin(2 * std::numbers::pi * turns_ * s / travel_ + phase_) : 0, 0);
        }
    }

  private:
    int kind_;
    CameraModel camera_;
    double phase_, angle_, wave_px_, travel_, turns_;
};

/// Rms in px that the error of amplitude 1 leaves after the best refit, in first order.
double left_px(const Trial& trial, const ModelError& error) {
    const Eigen::MatrixXd modes = covariance_modes(drawing_covariance(trial.drawn));
    std::vector<ProjectedView> parts;
    Eigen::MatrixXd information = Eigen::MatrixXd::Identity(modes.cols(), modes.cols());
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(modes.cols());
    for (const CornerView& view : trial.views) {
        ViewData data =
            measured_view(trial.truth, trial.board, view, trial.options.corner_noise_px, 1, 100);
        ViewData moved = data;
        for (auto& c : moved.corners) c.pixel += error.at(c.pixel, c.s, false);
        for (auto& s : moved.stripes) s.pixel += error.at(s.pixel, s.s, true);
        ProjectedView part = projected_view(trial.truth, modes, data);
        const Eigen::VectorXd change = view_rows(trial.truth, modes, moved).residual -
                                       view_rows(trial.truth, modes, data).residual;
        part.residual = change - part.pose_basis * (part.pose_basis.transpose() * change);
        information += part.information();
        gradient += part.gradient();
        parts.push_back(std::move(part));
    }
    const Eigen::VectorXd step = -information.ldlt().solve(gradient);
    double squares = 0, count = 0;
    for (const ProjectedView& part : parts) {
        const Eigen::VectorXd left = part.residual + part.by_mode * step;
        const auto corner_rows = 2 * static_cast<Eigen::Index>(part.data.corners.size());
        const Eigen::VectorXd rows = error.is_of_the_sheet()
                                         ? left.tail(left.size() - corner_rows).eval()
                                         : left.head(corner_rows).eval();
        squares += rows.squaredNorm();
        count += static_cast<double>(rows.size());
    }
    return std::sqrt(squares / count) * (error.is_of_the_sheet() ? trial.options.stripe_noise_px
                                                                 : trial.options.corner_noise_px);
}

void inject(Trial& trial, int kind) {
    const ModelError error(kind, trial.truth.channels[0].camera, trial.truth.channels[0].axis.kind,
                           trial.rng);
    const double amplitude = kLeftPx / left_px(trial, error);
    for (CornerView& view : trial.views) {
        for (BoardCorners& seen : view.corners)
            for (auto& pixel : seen.pixels) pixel += amplitude * error.at(pixel, seen.s, false);
        for (Pulse& pulse : view.pulses.pulses) {
            const Eigen::Vector2d move = amplitude * error.at({pulse.u, pulse.v}, pulse.s, true);
            pulse.u += static_cast<float>(move.x());
            pulse.v += static_cast<float>(move.y());
        }
    }
}

void print(const char* what, int trial, const CrossValidation& found) {
    std::cout << what << ' ' << trial << ": p " << found.p_value;
    for (const SplitCheck& split : found.splits)
        std::cout << ", " << split.how << ' ' << split.difference_mm << " of " << split.expected_mm
                  << " mm (chi2 " << split.chi_square << " / " << split.degrees << ")";
    std::cout << ", corners z " << found.corners.z << " (" << found.corners.model_error
              << " px), stripes z " << found.stripes.z << ", by axis z " << found.stripes_by_axis.z
              << ", axis run z " << found.axis_run.z << std::endl;
}

TEST(CrossValidation, NoiseAloneRaisesNoAlarm) {
    const int trials = STRIA_NULL_TRIALS;
    int alarms = 0, below_5_percent = 0;
    for (int i = 0; i < trials; ++i) {
        const Trial trial(MachineKind(i % 3), 1000U + static_cast<unsigned>(i));
        const CrossValidation found = trial.judge();
        if (i < 3 || found.alarm()) print("null", i, found);
        alarms += found.alarm();
        below_5_percent += found.p_value < 0.05;
        if (i < 3) {
            ASSERT_EQ(found.splits.size(), 2U);
            for (const SplitCheck& split : found.splits) {
                EXPECT_TRUE(split.done);
                EXPECT_EQ(split.views_a + split.views_b, 12);
                EXPECT_GT(split.degrees, 10);
            }
        }
    }
    std::cout << alarms << " alarms in " << trials << " null trials, " << below_5_percent
              << " below 5 %" << std::endl;
    EXPECT_LE(alarms, trials / 100);
}

TEST(CrossValidation, AModelErrorOfATenthOfAPixelIsFound) {
    const int trials = STRIA_MODEL_ERRORS;
    int found_ones = 0;
    for (int i = 0; i < trials; ++i) {
        Trial trial(MachineKind(i % 3), 5000U + static_cast<unsigned>(i));
        inject(trial, i % 5);
        const CrossValidation found = trial.judge();
        if (i < 5 || !found.alarm()) print("injected", i, found);
        found_ones += found.alarm();
    }
    std::cout << found_ones << " of " << trials << " model errors found" << std::endl;
    EXPECT_GE(found_ones, std::ceil(0.95 * trials));
}

TEST(CrossValidation, TooFewViewsAreNotSplit) {
    Trial trial(MachineKind::rail, 3);
    trial.views.resize(6);
    const CrossValidation found = trial.judge();
    for (const SplitCheck& split : found.splits) EXPECT_FALSE(split.done);
    EXPECT_GT(found.corners.pairs, 1000U);
}

}  // namespace
}  // namespace stria

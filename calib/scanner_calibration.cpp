#include "calib/scanner_calibration.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calib/axis_start.h"
#include "calib/calibration_summary.h"
#include "calib/calibration_warnings.h"
#include "calib/camera_calibration.h"
#include "calib/detect_board.h"
#include "calib/mirror_tilt.h"
#include "calib/scanner_problem.h"
#include "calib/stripe_points.h"
#include "firmware/core/median.h"
#include "host/core/errors.h"

namespace stria {
namespace {

constexpr int kLeastViews = 3;
constexpr int kLeastStripePoints = 50;

constexpr int kCellsKept = 60000;  ///< of a pulse map; a hundred times the points used

/// One camera and one axis for all lasers.
void check_channels(const std::vector<Channel>& channels) {
    const auto refuse = [](std::size_t c, const std::string& why) {
        throw std::invalid_argument("nominal: channel " + std::to_string(c) + " " + why);
    };
    if (channels.empty()) throw std::invalid_argument("nominal: 0 channels, expected 1 or more");
    const Channel& first = channels.front();
    for (std::size_t c = 1; c < channels.size(); ++c) {
        const Channel& other = channels[c];
        if (other.camera_id != first.camera_id)
            refuse(c, "has camera " + std::to_string(other.camera_id) + ", channel 0 camera " +
                          std::to_string(first.camera_id) +
                          ": the lasers of one camera are calibrated together, each camera alone");
        if (other.axis.kind != first.axis.kind)
            refuse(c, std::string("has axis kind ") + name_of(other.axis.kind) + ", channel 0 " +
                          name_of(first.axis.kind) + ": expected the same axis");
        for (std::size_t b = 0; b < c; ++b)
            if (channels[b].laser_id == other.laser_id)
                refuse(c, "has laser " + std::to_string(other.laser_id) + " as channel " +
                              std::to_string(b) + " has: expected one channel a laser");
    }
}

void check(const ScannerModel& nominal, const Board& board,
           const ScannerCalibrationOptions& options) {
    check_channels(nominal.channels);
    if (const std::string why = validate(nominal); !why.empty())
        throw std::invalid_argument("nominal: " + why);
    if (options.stripe_points_per_view < kLeastStripePoints)
        throw std::invalid_argument(
            "stripe_points_per_view = " + std::to_string(options.stripe_points_per_view) +
            ": expected at least " + std::to_string(kLeastStripePoints));
    if (nominal.channels[0].axis.kind != MachineKind::swept && looks_same_turned(board))
        throw Error("board " + to_string(board) +
                    " looks the same when it is turned, so its motion with the axis is ambiguous; "
                    "use a ChArUco board, or a chessboard with one odd and one even number of "
                    "corners");
}

/// The whole calibration of one call: each step reads what the former left.
class Calibrator {
  public:
    Calibrator(const std::vector<CornerView>& views, const Board& board,
               const ScannerModel& nominal, const ScannerCalibrationOptions& options)
        : views_(views),
          board_(board),
          nominal_(nominal),
          options_(options),
          problem_(board, nominal.channels, options) {
        result_.views.resize(views.size());
        for (std::size_t v = 0; v < views.size(); ++v) {
            result_.views[v].name = views[v].name;
            result_.views[v].notes = views[v].refusals;
        }
    }

    ScannerCalibration run() {
        solve_camera();
        start_axis_and_views();
        take_stripes();
        solve_sheet();
        solve_jointly();
        summarise(problem_, source_, nominal_, board_, camera_.noise, result_);
        return std::move(result_);
    }

  private:
    void solve_camera();
    void start_axis_and_views();
    void take_stripes();
    std::vector<StripePoint> stripes_of(std::size_t view, const Channel& channel,
                                        const BoardColours& colours) const;
    void solve_sheet();
    void solve_jointly();

    void estimate_sigmas(bool robust);
    void reject_outliers();

    const std::vector<CornerView>& views_;
    const Board& board_;
    const ScannerModel& nominal_;
    const ScannerCalibrationOptions& options_;
    CameraCalibration camera_;
    ScannerProblem problem_;
    std::vector<std::size_t> source_;  ///< of each view of the problem, index into views_
    ScannerCalibration result_;
};

void Calibrator::solve_camera() {
    const CameraModel& drawn = nominal_.channels[0].camera;
    camera_ =
        calibrate_camera(pictures_of(views_), board_, drawn.width, drawn.height,
                         {.lens = drawn.kind, .board_warp = options_.board_warp, .start = drawn});
    problem_.warp = {camera_.board_warp_mm.x(), camera_.board_warp_mm.y()};
}

void Calibrator::start_axis_and_views() {
    std::vector<PosesAlongAxis> along(views_.size());
    std::vector<ScannerProblem::View> found(views_.size());
    std::size_t picture = 0;
    for (std::size_t v = 0; v < views_.size(); ++v)
        for (const BoardCorners& seen : views_[v].corners) {
            const CameraViewResult& solved = camera_.views[picture++];
            if (!solved.rejected.empty()) {
                result_.views[v].notes.push_back(seen.name + ": " + solved.rejected);
                continue;
            }
            along[v].s.push_back(seen.s);
            along[v].camera_from_board.push_back(solved.camera_from_board);
            ++result_.views[v].images_used;
            for (std::size_t i = 0; i < seen.ids.size(); ++i)
                found[v].corners.push_back({seen.ids[i], seen.pixels[i], seen.s});
        }
    Channel channel = nominal_.channels[0];
    channel.camera = camera_.camera;
    const AxisStart start = start_axis(channel.axis, along);
    channel.axis = start.axis;
    if (std::abs(start.scale - 1) > 0.02)
        result_.warnings.push_back("the board moved " + std::to_string(start.scale) +
                                   " times as far as the axis says: check steps per unit");
    problem_.set_camera_and_axis(channel.camera, channel.axis);
    for (std::size_t v = 0; v < views_.size(); ++v) {
        if (along[v].s.empty()) {
            result_.views[v].rejected = "no picture of it shows the board";
            continue;
        }
        const Rigid3 back = board_motion(channel, along[v].s[0]).inverse();
        found[v].pose = pose_block(back * along[v].camera_from_board[0]);
        source_.push_back(v);
        problem_.views.push_back(std::move(found[v]));
    }
    if (source_.size() < kLeastViews)
        throw Error("calibrating a scanner needs at least " + std::to_string(kLeastViews) +
                    " views that show the board, found " + std::to_string(source_.size()));
}

/// The passes of a view that hold pulses of a laser.
std::vector<const PulseMap*> passes_of_laser(const CornerView& view, std::uint8_t laser_id) {
    std::vector<const PulseMap*> passes;
    const auto take = [&](const PulseMap& map) {
        if (std::any_of(map.pulses.begin(), map.pulses.end(),
                        [&](const Pulse& pulse) { return pulse.laser_id == laser_id; }))
            passes.push_back(&map);
    };
    take(view.pulses);
    for (const PulseMap& map : view.further_passes) take(map);
    return passes;
}

std::vector<StripePoint> Calibrator::stripes_of(std::size_t view, const Channel& channel,
                                                const BoardColours& colours) const {
    const auto passes = passes_of_laser(views_[source_[view]], channel.laser_id);
    const Rigid3 pose = rigid_from_block(problem_.views[view].pose.data());
    std::vector<StripePoint> points;
    for (const PulseMap* pass : passes)
        for (const StripePoint& point : stripe_points_on_board(
                 *pass, channel, pose, colours,
                 options_.stripe_points_per_view / static_cast<int>(passes.size())))
            points.push_back(point);
    return points;
}

void Calibrator::take_stripes() {
    const BoardColours colours(board_);
    for (std::size_t i = 0; i < source_.size(); ++i)
        if (views_[source_[i]].pulses.undersampled)
            result_.views[source_[i]].notes.push_back("its sweep is undersampled: no pulses used");
    const std::vector<Channel> channels = problem_.channels();
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const std::string laser =
            channels.size() == 1 ? "" : " of laser " + std::to_string(channels[c].laser_id);
        std::size_t total = 0, with_stripe = 0;
        for (std::size_t i = 0; i < source_.size(); ++i) {
            const auto points = stripes_of(i, channels[c], colours);
            if (points.size() < static_cast<std::size_t>(kLeastStripePoints) &&
                !views_[source_[i]].pulses.undersampled)
                result_.views[source_[i]].notes.push_back("only " + std::to_string(points.size()) +
                                                          " usable stripe points" + laser +
                                                          " on the board");
            for (const StripePoint& point : points) problem_.views[i].stripes.push_back({point, c});
            total += points.size();
            with_stripe += points.size() >= static_cast<std::size_t>(kLeastStripePoints);
        }
        if (with_stripe < 2)
            throw Error(
                "calibrating a scanner needs at least 2 views with the stripe" + laser +
                " on the board, found " + std::to_string(with_stripe) + " (" +
                std::to_string(total) +
                " usable stripe points in all views): is the laser on, its sweep crossing the "
                "board, and the board the one stated?");
    }
}

void Calibrator::solve_sheet() {
    // The sheet may start 20 mm off: Huber's border follows the residuals down, so that the bulk of
    // the points pulls and strays do not.
    const ScannerProblem::Stage all = problem_.everything();
    ScannerProblem::Stage stage;
    stage.camera = stage.corners = false;
    stage.sheet_free = {0, 1, 2};
    stage.every = std::max(1, options_.stripe_points_per_view / 80);
    stage.max_iterations = 20;
    const bool swept = problem_.channels().front().axis.kind == MachineKind::swept;
    for (int round = 0; round < 6; ++round) {
        if (swept && round == 0) stage.axis_free = {4, 5};
        if (swept && round > 0) stage.axis_free = {0, 1, 2, 3, 4, 5, 6};
        if (swept && round > 2) stage.axis_free = all.axis_free;
        if (round > 2) stage.sheet_free = all.sheet_free;
        stage.mirror_bounded = round < 3;
        problem_.weigh_stripes();
        std::vector<double> sizes = problem_.stripe_residuals();
        for (double& r : sizes) r = std::abs(r);
        stage.huber_sigmas = std::max(2.0, 2 * median(sizes));
        if (round == 5) stage.max_iterations = 200;
        problem_.solve(stage);
    }
    problem_.weigh_stripes();
    std::vector<double> sizes = problem_.stripe_residuals();
    for (double& r : sizes) r = std::abs(r);
    const double limit = std::max(30.0, 15 * median(sizes));
    for (auto& view : problem_.views)
        for (auto& stripe : view.stripes)
            stripe.use = std::abs(problem_.residual_mm(view, stripe)) < limit * stripe.sigma_mm;
}

void Calibrator::estimate_sigmas(bool robust) {
    const auto spread = [&](std::vector<double> values) {
        if (values.empty()) return 1.0;
        if (robust) {
            for (double& value : values) value = std::abs(value);
            return 1.4826 * median(values);
        }
        double sum = 0;
        for (double value : values) sum += value * value;
        return std::sqrt(sum / static_cast<double>(values.size()));
    };
    const auto sigma = [&](const std::vector<double>& residuals, int unknowns) {
        const auto rows = static_cast<double>(residuals.size());
        return std::max(1e-6, spread(residuals) * std::sqrt(rows / std::max(1.0, rows - unknowns)));
    };
    problem_.corner_sigma_px = sigma(problem_.corner_residuals(), problem_.corner_unknowns());
    problem_.stripe_sigma_factor = sigma(problem_.stripe_residuals(), problem_.stripe_unknowns());
}

void Calibrator::reject_outliers() {
    for (auto& view : problem_.views) {
        for (auto& corner : view.corners)
            corner.use =
                problem_.residual(view, corner).norm() < 6 * 1.5 * problem_.corner_sigma_px;
        for (auto& stripe : view.stripes)
            stripe.use = std::abs(problem_.residual_mm(view, stripe)) <
                         5 * problem_.stripe_sigma_factor * stripe.sigma_mm;
    }
}

void Calibrator::solve_jointly() {
    ScannerProblem::Stage stage = problem_.everything();
    problem_.corner_sigma_px = std::max(1e-6, camera_.sigma_pixel);
    stage.huber_sigmas = 3;
    stage.max_iterations = 30;
    for (int round = 0; round < 2; ++round) {
        problem_.weigh_stripes();
        problem_.solve(stage);
        problem_.weigh_stripes();
        estimate_sigmas(true);
    }
    reject_outliers();
    stage.huber_sigmas = 0;
    stage.max_iterations = 12;  // who has not arrived by then creeps
    stage.valley_iterations = 100;
    SolveEnd end;
    OtherMirror other;
    for (int round = 0; round < 3; ++round) {
        end = problem_.solve(stage);
        if (round == 0)
            other = take_better_mirror(problem_, stage, 2 * options_.nominal_angle_sigma_rad);
        if (round == 2) break;  // the last solve and the covariance share their weights
        problem_.weigh_stripes();
        estimate_sigmas(false);
    }
    result_.converged = end.converged;
    if (const std::string alike = alike_mirrors(other.margin); !alike.empty())
        result_.warnings.push_back(alike);
    const std::string far =
        far_from_drawing(problem_.channels().front().axis, nominal_.channels.front().axis,
                         0.95 * kMostMirrorTurn * options_.nominal_angle_sigma_rad);
    if (far.empty()) return;
    result_.converged = false;
    result_.warnings.push_back(far);
}

}  // namespace

CornerView find_corners(const CalibrationView& view, const Board& board) {
    CornerView found;
    found.name = view.name;
    found.pulses = thinned(view.pulses, kCellsKept);
    for (const PulseMap& pass : view.further_passes)
        found.further_passes.push_back(thinned(pass, kCellsKept));
    for (std::size_t i = 0; i < view.images.size(); ++i) {
        const std::string name = view.name + " picture " + std::to_string(i + 1);
        Detection detection = detect_board(view.images[i].image, board);
        if (detection.found())
            found.corners.push_back(
                {name, view.images[i].s, std::move(detection.ids), std::move(detection.pixels)});
        else
            found.refusals.push_back(name + ": " + detection.refusal);
    }
    return found;
}

std::vector<CameraView> pictures_of(const std::vector<CornerView>& views) {
    std::vector<CameraView> pictures;
    for (const CornerView& view : views)
        for (const BoardCorners& seen : view.corners)
            pictures.push_back({seen.name, seen.ids, seen.pixels, {}});
    return pictures;
}

ScannerCalibration calibrate_scanner(const std::vector<CornerView>& views, const Board& board,
                                     const ScannerModel& nominal,
                                     const ScannerCalibrationOptions& options) {
    check(nominal, board, options);
    return Calibrator(views, board, nominal, options).run();
}

ScannerCalibration calibrate_scanner(const std::vector<CalibrationView>& views, const Board& board,
                                     const ScannerModel& nominal,
                                     const ScannerCalibrationOptions& options) {
    check(nominal, board, options);
    std::vector<CornerView> found;
    for (const CalibrationView& view : views) found.push_back(find_corners(view, board));
    return calibrate_scanner(found, board, nominal, options);
}

}  // namespace stria

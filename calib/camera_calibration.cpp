#include "calib/camera_calibration.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "calib/camera_problem.h"
#include "calib/focal_start.h"
#include "firmware/core/median.h"
#include "host/core/errors.h"

namespace stria {
namespace {

constexpr int kLeastViews = 3;
constexpr int kLeastPoints = 6;

const std::vector<int> kFocalBarrel = {0, 1, 4};
const std::vector<int> kCentreAndBend = {0, 1, 2, 3, 4, 5};
const std::vector<int> kBrown = {0, 1, 2, 3, 4, 5, 6, 7, 8};

std::vector<int> free_entries(LensKind lens) {
    std::vector<int> free = {0, 1, 2, 3};
    for (int i = 0; i < distortion_count(lens); ++i) free.push_back(4 + i);
    return free;
}

void check_views(const std::vector<CameraView>& views, const Board& board) {
    const int count = static_cast<int>(board_points(board).size());
    for (const CameraView& view : views) {
        if (view.ids.size() != view.pixels.size() ||
            (!view.weights.empty() && view.weights.size() != view.ids.size()))
            throw std::invalid_argument("view " + view.name +
                                        ": ids, pixels and weights differ in number");
        for (int id : view.ids)
            if (id < 0 || id >= count)
                throw std::invalid_argument("view " + view.name + ": point id " +
                                            std::to_string(id) + " is not on the board");
        for (const Eigen::Vector2d& pixel : view.pixels)
            if (!pixel.allFinite())
                throw std::invalid_argument("view " + view.name + ": a pixel is not finite");
    }
}

int used_points(const CameraProblem::View& view) {
    return static_cast<int>(std::count(view.use.begin(), view.use.end(), 1));
}

void reject_short_views(CameraProblem& problem) {
    for (auto& view : problem.views)
        if (view.rejected.empty() && used_points(view) < kLeastPoints) {
            view.rejected = "too few corners: " + std::to_string(used_points(view)) +
                            " usable, at least " + std::to_string(kLeastPoints) + " needed";
            view.used = false;
        }
}

void need_views(const CameraProblem& problem) {
    std::string reasons;
    int used = 0;
    for (const auto& view : problem.views) {
        used += view.used;
        if (!view.used && !view.rejected.empty())
            reasons += "\n  " + view.source->name + ": " + view.rejected;
    }
    if (used < kLeastViews)
        throw Error("calibrating a camera needs at least " + std::to_string(kLeastViews) +
                    " usable views of the board, found " + std::to_string(used) + reasons);
}

/// Largest median deviation a coordinate has, from the lengths of 2-D residuals.
double robust_sigma_px(const std::vector<std::vector<double>>& lengths) {
    std::vector<double> all;
    for (const auto& view : lengths) all.insert(all.end(), view.begin(), view.end());
    return median(std::move(all)) / 1.17741;  // median of a Rayleigh distribution
}

/// Marks points far off all others as unused, views with a third of such points as rejected.
/// Returns whether anything changed.
bool reject_outliers(CameraProblem& problem) {
    const auto lengths = problem.residual_lengths();
    const double limit = std::max(1.0, 8 * robust_sigma_px(lengths));
    bool changed = false;
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
        auto& view = problem.views[v];
        if (!view.used) continue;
        const int before = used_points(view);
        std::size_t next = 0;
        for (auto& use : view.use)
            if (use && lengths[v][next++] > limit) use = 0;
        const int off = before - used_points(view);
        changed = changed || off > 0;
        if (3 * off >= before) {
            view.used = false;
            view.rejected = std::to_string(off) + " of " + std::to_string(before) +
                            " corners are more than " + std::to_string(limit) +
                            " px from where all other views put them";
        }
    }
    return changed;
}

void solve_in_stages(CameraProblem& problem, const CameraCalibrationOptions& options) {
    const double scale = std::max(0.5, robust_sigma_px(problem.residual_lengths()));
    if (options.lens != LensKind::pinhole) {
        problem.solve({.free = kFocalBarrel, .huber_px = 2 * scale, .max_iterations = 50});
        problem.solve({.free = kCentreAndBend, .huber_px = 4, .max_iterations = 50});
        problem.solve({.free = kBrown, .huber_px = 2, .max_iterations = 50});
    }
    problem.solve({.free = free_entries(options.lens),
                   .huber_px = 2,
                   .board_warp = options.board_warp,
                   .max_iterations = 200});
}

/// The greatest sigma of a focal length, as a share of it. Boards that are all parallel come to
/// rest at some length over ten times the true one, with a sigma of 0.23 of it and more.
constexpr double kGreatestFocalSigma = 0.1;

[[noreturn]] void refuse_parallel_views() {
    throw Error(
        "the views do not determine the camera: the board must be seen at several tilts (up to "
        "about 40 deg, to different sides), not always parallel to itself");
}

CameraCalibration summarise(CameraProblem& problem, const CameraCalibrationOptions& options,
                            int width, int height) {
    CameraCalibration result;
    result.camera.kind = options.lens;
    result.camera.width = width;
    result.camera.height = height;
    set_from_block(result.camera, problem.camera.data());
    result.board_warp_mm = {problem.warp[0], problem.warp[1]};
    const auto lengths = problem.residual_lengths();
    double sum = 0;
    for (std::size_t v = 0; v < problem.views.size(); ++v) {
        const auto& view = problem.views[v];
        CameraViewResult out;
        out.name = view.source->name;
        out.rejected = view.rejected;
        for (std::size_t i = 0; i < view.use.size(); ++i)
            if (!view.use[i]) out.ids_rejected.push_back(view.source->ids[i]);
        if (view.used) {
            double view_sum = 0;
            for (double length : lengths[v]) view_sum += length * length;
            out.points_used = static_cast<int>(lengths[v].size());
            out.rms_px = std::sqrt(view_sum / out.points_used);
            out.camera_from_board = rigid_from_block(view.pose.data());
            result.points_used += out.points_used;
            ++result.views_used;
            sum += view_sum;
        }
        result.views.push_back(std::move(out));
    }
    result.rms_px = std::sqrt(sum / result.points_used);
    const auto free = free_entries(options.lens);
    const double dof = 2.0 * result.points_used - static_cast<double>(free.size()) -
                       (options.board_warp ? 2 : 0) - 6.0 * result.views_used;
    result.sigma_pixel = dof > 0 ? std::sqrt(sum / dof) : 0;
    const auto rows = problem.corner_rows(free, options.board_warp);
    result.noise =
        options.shared_errors ? estimate_corner_noise(rows) : CornerNoise{result.sigma_pixel};
    const auto count = static_cast<Eigen::Index>(free.size());
    result.covariance = shared_covariance(rows, result.noise).topLeftCorner(count, count);
    // exact corners prove nothing
    const CornerNoise white{std::max(result.sigma_pixel, 1e-3)};
    const double focal_sigma = std::sqrt(shared_covariance(rows, white)(0, 0));
    if (focal_sigma > kGreatestFocalSigma * std::abs(result.camera.fx)) refuse_parallel_views();
    return result;
}

}  // namespace

CameraCalibration calibrate_camera(const std::vector<CameraView>& views, const Board& board,
                                   int width, int height, const CameraCalibrationOptions& options) {
    check_views(views, board);
    CameraProblem problem(views, board);
    reject_short_views(problem);
    choose_start(problem, board, width, height, options);
    need_views(problem);
    solve_in_stages(problem, options);
    for (int round = 0; round < 3 && options.reject_outliers; ++round) {
        if (!reject_outliers(problem)) break;
        reject_short_views(problem);
        need_views(problem);
        problem.solve(
            {.free = free_entries(options.lens), .huber_px = 2, .board_warp = options.board_warp});
    }
    const auto summary = problem.solve({.free = free_entries(options.lens),
                                        .board_warp = options.board_warp,
                                        .max_iterations = 300});
    CameraCalibration result = summarise(problem, options, width, height);
    result.converged = summary.termination_type == ceres::CONVERGENCE;
    result.iterations = static_cast<int>(summary.iterations.size());
    return result;
}

}  // namespace stria

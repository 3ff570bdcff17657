#include "calib/focal_start.h"

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "calib/lens_choice.h"

namespace stria {
namespace {

CameraModel simple_camera(double focal_px, int width, int height, LensKind lens) {
    CameraModel camera;
    camera.kind = lens;
    camera.width = width;
    camera.height = height;
    camera.fx = camera.fy = focal_px;
    camera.cx = 0.5 * (width - 1);
    camera.cy = 0.5 * (height - 1);
    return camera;
}

/// Zhang's closed form with the principal point in the middle; 0 where the views give none.
double zhang_focal_px(const CameraProblem& problem, const Board& board, int width, int height) {
    const auto points = board_points(board);
    std::vector<std::vector<cv::Point3f>> on_board;
    std::vector<std::vector<cv::Point2f>> in_image;
    for (const auto& view : problem.views) {
        if (!view.rejected.empty()) continue;
        std::vector<cv::Point3f> from;
        std::vector<cv::Point2f> to;
        for (std::size_t i = 0; i < view.use.size(); ++i) {
            if (!view.use[i]) continue;
            const Eigen::Vector3d& p = points[static_cast<std::size_t>(view.source->ids[i])];
            from.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
            to.emplace_back(static_cast<float>(view.source->pixels[i].x()),
                            static_cast<float>(view.source->pixels[i].y()));
        }
        on_board.push_back(from);
        in_image.push_back(to);
    }
    if (on_board.empty()) return 0;
    try {
        const cv::Mat k = cv::initCameraMatrix2D(on_board, in_image, cv::Size(width, height), 1.0);
        const double focal = k.at<double>(0, 0);
        return std::isfinite(focal) ? focal : 0;
    } catch (const cv::Exception&) {
        return 0;  // no homography
    }
}

/// Mean distance of the points from their places, px, none counted above 50.
double robust_mean_px(const CameraProblem& problem) {
    double sum = 0, count = 0;
    for (const auto& view : problem.residual_lengths())
        for (double length : view) {
            sum += std::min(length, 50.0);
            ++count;
        }
    return count > 0 ? sum / count : 50.0;
}

}  // namespace

void choose_start(CameraProblem& problem, const Board& board, int width, int height,
                  const CameraCalibrationOptions& options) {
    std::vector<CameraModel> candidates;
    if (options.start) {
        candidates.push_back(with_lens(*options.start, options.lens));
    }
    const double zhang = zhang_focal_px(problem, board, width, height);
    if (zhang > 0.1 * width && zhang < 100.0 * width)
        candidates.push_back(simple_camera(zhang, width, height, options.lens));
    for (double share : {0.3, 0.6, 1.2, 2.4, 4.0})
        candidates.push_back(simple_camera(share * width, width, height, options.lens));

    double best_cost = std::numeric_limits<double>::infinity();
    CameraProblem best = problem;
    for (const CameraModel& candidate : candidates) {
        CameraProblem trial = problem;
        Eigen::Map<Eigen::Matrix<double, kCameraSize, 1>>(trial.camera.data()) =
            camera_block(candidate);
        trial.find_poses(candidate);
        int missing = 0;
        for (const auto& view : trial.views) missing += view.rejected.empty() && !view.used;
        std::vector<int> free = {0, 1};
        if (options.lens != LensKind::pinhole) free.push_back(4);
        trial.solve({.free = free, .huber_px = 3, .max_iterations = 25});
        const double cost = robust_mean_px(trial) + 50.0 * missing;
        if (cost < best_cost) {
            best_cost = cost;
            best.camera = trial.camera;
            best.views = trial.views;
        }
        if (cost < 2) break;  // px: nothing will be better by much
    }
    problem.camera = best.camera;
    problem.views = best.views;
    for (auto& view : problem.views)
        if (view.rejected.empty() && !view.used)
            view.rejected = "no pose of the board explains its corners";
}

}  // namespace stria

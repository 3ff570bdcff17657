#include <ceres/ceres.h>

#include <opencv2/calib3d.hpp>

#include "calib/camera_calibration.h"
#include "calib/camera_cost.h"

namespace stria {
namespace {

struct PoseCost {
    const double* camera;
    Eigen::Vector3d point;
    Eigen::Vector2d pixel;

    template <typename T>
    bool operator()(const T* pose, T* residual) const {
        T block[kCameraSize], start[3], moved[3];
        for (int i = 0; i < kCameraSize; ++i) block[i] = T(camera[i]);
        for (int i = 0; i < 3; ++i) start[i] = T(point[i]);
        move_by_block(pose, start, moved);
        if (!project_block(block, moved, residual)) return false;
        residual[0] -= pixel.x();
        residual[1] -= pixel.y();
        return true;
    }
};

}  // namespace

std::optional<Rigid3> board_pose(const CameraModel& camera, const CameraView& view,
                                 const Board& board) {
    if (view.ids.size() < 4) return std::nullopt;
    const auto points = board_points(board);
    std::vector<cv::Point3d> on_board;
    std::vector<cv::Point2d> ideal;
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
        const Eigen::Vector3d& p = points[static_cast<std::size_t>(view.ids[i])];
        on_board.emplace_back(p.x(), p.y(), 0);  // the warp follows
        const Eigen::Vector3d ray = ray_through(camera, view.pixels[i]);
        if (!ray.allFinite()) return std::nullopt;
        ideal.emplace_back(ray.x(), ray.y());
    }
    cv::Mat rotation, translation;
    try {
        if (!cv::solvePnP(on_board, ideal, cv::Matx33d::eye(), cv::noArray(), rotation, translation,
                          false, cv::SOLVEPNP_IPPE))
            return std::nullopt;
    } catch (const cv::Exception&) {
        return std::nullopt;  // degenerate points
    }
    Vector6d pose;
    for (int i = 0; i < 3; ++i) {
        pose[i] = rotation.at<double>(i);
        pose[3 + i] = translation.at<double>(i);
    }
    if (!pose.allFinite()) return std::nullopt;

    const auto block = camera_block(camera);
    ceres::Problem problem;
    for (std::size_t i = 0; i < view.ids.size(); ++i)
        problem.AddResidualBlock(
            new ceres::AutoDiffCostFunction<PoseCost, 2, kPoseSize>(new PoseCost{
                block.data(), points[static_cast<std::size_t>(view.ids[i])], view.pixels[i]}),
            new ceres::HuberLoss(3.0), pose.data());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    if (!summary.IsSolutionUsable() || !pose.allFinite()) return std::nullopt;
    return rigid_from_block(pose.data());
}

double view_rms_px(const CameraModel& camera, const Rigid3& camera_from_board,
                   const CameraView& view, const Board& board) {
    const auto points = board_points(board);
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < view.ids.size(); ++i) {
        if (!view.weights.empty() && !(view.weights[i] > 0)) continue;
        const auto pixel =
            project(camera, camera_from_board * points[static_cast<std::size_t>(view.ids[i])]);
        if (!pixel) return std::numeric_limits<double>::infinity();
        sum += (*pixel - view.pixels[i]).squaredNorm();
        ++count;
    }
    return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace stria

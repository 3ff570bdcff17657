#include "calib/camera_problem.h"

#include <algorithm>
#include <cmath>

#include "calib/schur_information.h"

namespace stria {
namespace {

struct PointCost {
    Eigen::Vector3d point;
    Eigen::Vector2d span;
    Eigen::Vector2d pixel;
    double weight;

    template <typename T>
    bool operator()(const T* camera, const T* pose, const T* warp, T* residual) const {
        const T on_board[3] = {
            T(point.x()), T(point.y()),
            warp[0] * (1 - span.x() * span.x()) + warp[1] * (1 - span.y() * span.y())};
        T moved[3];
        move_by_block(pose, on_board, moved);
        if (!project_block(camera, moved, residual)) return false;
        residual[0] = weight * (residual[0] - pixel.x());
        residual[1] = weight * (residual[1] - pixel.y());
        return true;
    }
};

double weight_of(const CameraView& view, std::size_t i) {
    return view.weights.empty() ? 1.0 : view.weights[i];
}

}  // namespace

CameraProblem::CameraProblem(const std::vector<CameraView>& sources, const Board& board)
    : points_(board_points(board)), board_(board) {
    Eigen::Vector2d low = points_.front().head<2>(), high = low;
    for (const Eigen::Vector3d& p : points_) {
        low = low.cwiseMin(p.head<2>());
        high = high.cwiseMax(p.head<2>());
    }
    for (const Eigen::Vector3d& p : points_)
        span_.push_back((2 * (p.head<2>() - low)).cwiseQuotient(high - low).array() - 1.0);
    for (const CameraView& source : sources) {
        View view;
        view.source = &source;
        for (std::size_t i = 0; i < source.ids.size(); ++i)
            view.use.push_back(weight_of(source, i) > 0);
        views.push_back(std::move(view));
    }
}

void CameraProblem::find_poses(const CameraModel& start) {
    for (View& view : views) {
        if (!view.rejected.empty()) continue;
        CameraView kept;
        for (std::size_t i = 0; i < view.use.size(); ++i)
            if (view.use[i]) {
                kept.ids.push_back(view.source->ids[i]);
                kept.pixels.push_back(view.source->pixels[i]);
            }
        const auto pose = board_pose(start, kept, board_);
        view.used = pose.has_value();
        if (pose) view.pose = pose_block(*pose);
    }
}

void CameraProblem::build(ceres::Problem& problem, const Solve& how) {
    for (View& view : views) {
        if (!view.used) continue;
        for (std::size_t i = 0; i < view.use.size(); ++i) {
            if (!view.use[i]) continue;
            const auto id = static_cast<std::size_t>(view.source->ids[i]);
            problem.AddResidualBlock(
                new ceres::AutoDiffCostFunction<PointCost, 2, kCameraSize, kPoseSize, 2>(
                    new PointCost{points_[id], span_[id], view.source->pixels[i],
                                  weight_of(*view.source, i)}),
                how.huber_px > 0 ? new ceres::HuberLoss(how.huber_px) : nullptr, camera.data(),
                view.pose.data(), warp.data());
        }
    }
    if (!problem.HasParameterBlock(camera.data())) return;
    std::vector<int> held;
    for (int i = 0; i < kCameraSize; ++i)
        if (std::find(how.free.begin(), how.free.end(), i) == how.free.end()) held.push_back(i);
    if (!held.empty())
        problem.SetManifold(camera.data(), new ceres::SubsetManifold(kCameraSize, held));
    if (!how.board_warp) problem.SetParameterBlockConstant(warp.data());
}

ceres::Solver::Summary CameraProblem::solve(const Solve& how) {
    ceres::Problem problem;
    build(problem, how);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = how.max_iterations;
    options.function_tolerance = 1e-12;
    options.parameter_tolerance = 1e-12;
    options.gradient_tolerance = 1e-12;
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (View& view : views)
        if (view.used && problem.HasParameterBlock(view.pose.data()))
            ordering->AddElementToGroup(view.pose.data(), 0);
    if (problem.HasParameterBlock(camera.data())) {
        ordering->AddElementToGroup(camera.data(), 1);
        ordering->AddElementToGroup(warp.data(), 1);
    }
    options.linear_solver_ordering = ordering;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    return summary;
}

std::vector<std::vector<double>> CameraProblem::residual_lengths() const {
    std::vector<std::vector<double>> lengths(views.size());
    for (std::size_t v = 0; v < views.size(); ++v) {
        const View& view = views[v];
        if (!view.used) continue;
        for (std::size_t i = 0; i < view.use.size(); ++i) {
            if (!view.use[i]) continue;
            const auto id = static_cast<std::size_t>(view.source->ids[i]);
            const PointCost cost{points_[id], span_[id], view.source->pixels[i], 1.0};
            double residual[2];
            const bool seen = cost(camera.data(), view.pose.data(), warp.data(), residual);
            lengths[v].push_back(seen ? std::hypot(residual[0], residual[1]) : 1e6);
        }
    }
    return lengths;
}

Eigen::MatrixXd CameraProblem::information(const std::vector<int>& free, bool board_warp) {
    ceres::Problem problem;
    build(problem, {.free = free, .board_warp = board_warp});
    std::vector<double*> shared = {camera.data()}, separate;
    if (board_warp) shared.push_back(warp.data());
    for (View& view : views)
        if (view.used && problem.HasParameterBlock(view.pose.data()))
            separate.push_back(view.pose.data());
    return schur_information(problem, shared, separate);
}

}  // namespace stria

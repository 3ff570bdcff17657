#include "calib/camera_problem.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

struct PointCost {
    Eigen::Vector3d point;
    Eigen::Vector2d rise;
    Eigen::Vector2d pixel;
    double weight;

    template <typename T>
    bool operator()(const T* camera, const T* pose, const T* warp, T* residual) const {
        const T on_board[3] = {T(point.x()), T(point.y()), warp[0] * rise.x() + warp[1] * rise.y()};
        T moved[3];
        move_by_block(pose, on_board, moved);
        if (!project_block(camera, moved, residual)) return false;
        residual[0] = weight * (residual[0] - pixel.x());
        residual[1] = weight * (residual[1] - pixel.y());
        return true;
    }
};

using AutoDiffPoint = ceres::AutoDiffCostFunction<PointCost, 2, kCameraSize, kPoseSize, 2>;

struct PointRows {
    Eigen::Vector2d residual;
    Eigen::Matrix<double, 2, kCameraSize, Eigen::RowMajor> by_camera;
    Eigen::Matrix<double, 2, kPoseSize, Eigen::RowMajor> by_pose;
    Eigen::Matrix<double, 2, 2, Eigen::RowMajor> by_warp;
};

/// False if the point is not in front of the camera.
bool linearise(const PointCost& cost, const std::array<double, kCameraSize>& camera,
               const Vector6d& pose, const std::array<double, 2>& warp, PointRows& rows) {
    const double* parameters[] = {camera.data(), pose.data(), warp.data()};
    double* jacobians[] = {rows.by_camera.data(), rows.by_pose.data(), rows.by_warp.data()};
    return AutoDiffPoint(new PointCost(cost)).Evaluate(parameters, rows.residual.data(), jacobians);
}

double weight_of(const CameraView& view, std::size_t i) {
    return view.weights.empty() ? 1.0 : view.weights[i];
}

}  // namespace

CameraProblem::CameraProblem(const std::vector<CameraView>& sources, const Board& board)
    : warp{board.warp_mm.x(), board.warp_mm.y()}, points_(board_points(board)), board_(board) {
    const BoardRise rise(points_);
    for (const Eigen::Vector3d& p : points_) rises_.push_back(rise.at(p.head<2>()));
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
                new AutoDiffPoint(new PointCost{points_[id], rises_[id], view.source->pixels[i],
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
            const PointCost cost{points_[id], rises_[id], view.source->pixels[i], 1.0};
            double residual[2];
            const bool seen = cost(camera.data(), view.pose.data(), warp.data(), residual);
            lengths[v].push_back(seen ? std::hypot(residual[0], residual[1]) : 1e6);
        }
    }
    return lengths;
}

std::vector<CornerRows> CameraProblem::corner_rows(const std::vector<int>& free,
                                                   bool board_warp) const {
    const auto shared = static_cast<Eigen::Index>(free.size()) + (board_warp ? 2 : 0);
    std::vector<CornerRows> result;
    for (const View& view : views) {
        if (!view.used) continue;
        CornerRows rows;
        std::vector<PointRows> points;
        for (std::size_t i = 0; i < view.use.size(); ++i) {
            if (!view.use[i]) continue;
            const auto id = static_cast<std::size_t>(view.source->ids[i]);
            const PointCost cost{points_[id], rises_[id], view.source->pixels[i],
                                 weight_of(*view.source, i)};
            PointRows point;
            if (!linearise(cost, camera, view.pose, warp, point)) continue;
            points.push_back(point);
            rows.on_board.push_back(points_[id].head<2>() / board_.pitch_mm);
        }
        if (points.empty()) continue;
        const auto count = static_cast<Eigen::Index>(points.size());
        rows.residual.resize(2 * count);
        rows.by_pose.resize(2 * count, kPoseSize);
        rows.by_shared.resize(2 * count, shared);
        for (Eigen::Index i = 0; i < count; ++i)
            for (int c = 0; c < 2; ++c) {
                const PointRows& point = points[static_cast<std::size_t>(i)];
                const Eigen::Index row = c * count + i;
                rows.residual[row] = point.residual[c];
                rows.by_pose.row(row) = point.by_pose.row(c);
                Eigen::Index column = 0;
                for (int entry : free) rows.by_shared(row, column++) = point.by_camera(c, entry);
                if (board_warp) rows.by_shared.row(row).tail<2>() = point.by_warp.row(c);
            }
        result.push_back(std::move(rows));
    }
    return result;
}

}  // namespace stria

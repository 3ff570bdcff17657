#include "calib/linear_view.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "calib/camera_calibration.h"

namespace stria {
namespace {

constexpr double kModeStep = 0.05;    ///< standard deviations
constexpr double kTurnStep = 1e-5;    ///< rad
constexpr double kShiftStep = 1e-3;   ///< mm
constexpr double kLeastMode = 1e-12;  ///< of the correlation matrix's eigenvalues
constexpr double kLost = 1e5;         ///< residual of a point out of sight

/// Residuals of the view with another channel and pose.
Eigen::VectorXd residuals(const Channel& channel, const Rigid3& pose, const ViewData& view) {
    Eigen::VectorXd r(static_cast<Eigen::Index>(2 * view.corners.size() + view.stripes.size()));
    Eigen::Index row = 0;
    double known_s = 0;
    Rigid3 at_s;
    bool known = false;
    for (const ViewData::Corner& corner : view.corners) {
        if (!known || corner.s != known_s) at_s = board_motion(channel, corner.s) * pose;
        known = true;
        known_s = corner.s;
        const auto pixel = project(channel.camera, at_s * corner.on_board);
        r.segment<2>(row) = pixel ? Eigen::Vector2d((*pixel - corner.pixel) / corner.sigma_px)
                                  : Eigen::Vector2d::Constant(kLost);
        row += 2;
    }
    for (const ViewData::Stripe& stripe : view.stripes) {
        const double d = distance_on_board(channel, pose, stripe.pixel, stripe.s, stripe.height_mm);
        r[row++] = std::isfinite(d) ? d / stripe.sigma_mm : kLost;
    }
    return r;
}

Rigid3 nudged(const Rigid3& pose, int entry, double step) {
    Vector6d delta = Vector6d::Zero();
    delta[entry] = step;
    return rigid_from_vector(delta) * pose;
}

bool has(const std::string& name, const char* part) { return name.find(part) != std::string::npos; }

}  // namespace

Eigen::MatrixXd covariance_modes(const Eigen::MatrixXd& covariance) {
    const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
    const Eigen::VectorXd inverse = sigma.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        Eigen::MatrixXd(inverse.asDiagonal() * covariance * inverse.asDiagonal()));
    Eigen::Index first = 0;
    while (first < eigen.eigenvalues().size() &&
           eigen.eigenvalues()[first] < kLeastMode * eigen.eigenvalues().maxCoeff())
        ++first;
    const Eigen::Index count = eigen.eigenvalues().size() - first;
    return sigma.asDiagonal() * eigen.eigenvectors().rightCols(count) *
           eigen.eigenvalues().tail(count).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd drawing_covariance(const ScannerModel& drawn,
                                   const ScannerCalibrationOptions& options) {
    const auto names = parameter_names(drawn);
    const CameraModel& camera = drawn.channels.front().camera;
    Eigen::VectorXd sigma = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(names.size()));
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::string& name = names[i];
        double& value = sigma[static_cast<Eigen::Index>(i)];
        if (!name.starts_with("channel0.")) continue;  // further channels share camera and axis
        if (has(name, "camera.f"))
            value = 0.03 * camera.fx;
        else if (has(name, "camera.c"))
            value = 0.03 * camera.width;
        else if (has(name, "camera.k"))
            value = 0.2;
        else if (has(name, "camera.p"))
            value = 0.01;
        else if (has(name, "sheet.bow"))
            value = options.bow_sigma;
        else if (has(name, "mirror.g"))
            value = options.gain_sigma;
        else if (has(name, "sheet.offset") || has(name, "mirror.offset") || has(name, "point_") ||
                 has(name, "table.tx") || has(name, "table.ty"))
            value = options.nominal_length_sigma_mm;
        else if (has(name, "tilt_") || has(name, "axis_") || has(name, "normal_") ||
                 has(name, "direction_") || has(name, "table.rx") || has(name, "table.ry"))
            value = options.nominal_angle_sigma_rad;
    }
    return sigma.cwiseAbs2().asDiagonal();
}

std::vector<Eigen::Vector2d> stripes_on_board(const Channel& channel, const ViewData& view) {
    std::vector<Eigen::Vector2d> points;
    for (const ViewData::Stripe& stripe : view.stripes) {
        const Rigid3 pose = board_motion(channel, stripe.s) * view.camera_from_board;
        const Eigen::Vector3d ray = ray_through(channel.camera, stripe.pixel);
        const Eigen::Vector3d normal = pose.rotation.col(2);
        const double depth = normal.dot(pose.translation) / normal.dot(ray);
        const Eigen::Vector3d p = pose.rotation.transpose() * (depth * ray - pose.translation);
        points.push_back(p.head<2>());
    }
    return points;
}

ViewRows view_rows(const ScannerModel& model, const Eigen::MatrixXd& modes, const ViewData& view) {
    const Channel& channel = model.channels.front();
    const Rigid3& pose = view.camera_from_board;
    ViewRows rows;
    rows.residual = residuals(channel, pose, view);
    const Eigen::Index count = rows.residual.size();
    rows.by_mode.resize(count, modes.cols());
    for (Eigen::Index k = 0; k < modes.cols(); ++k) {
        const Eigen::VectorXd step = kModeStep * modes.col(k);
        rows.by_mode.col(k) = (residuals(perturbed(model, step).channels.front(), pose, view) -
                               residuals(perturbed(model, -step).channels.front(), pose, view)) /
                              (2 * kModeStep);
    }
    rows.by_pose.resize(count, 6);
    for (int k = 0; k < 6; ++k) {
        const double step = k < 3 ? kTurnStep : kShiftStep;
        rows.by_pose.col(k) = (residuals(channel, nudged(pose, k, step), view) -
                               residuals(channel, nudged(pose, k, -step), view)) /
                              (2 * step);
    }
    for (Eigen::Index row = 0; row < count; ++row) {
        const double largest =
            std::max({std::abs(rows.residual[row]), rows.by_mode.row(row).cwiseAbs().maxCoeff(),
                      rows.by_pose.row(row).cwiseAbs().maxCoeff() * kShiftStep});
        if (std::isfinite(largest) && largest < kLost / 2) continue;
        rows.residual[row] = 0;
        rows.by_mode.row(row).setZero();
        rows.by_pose.row(row).setZero();
    }
    return rows;
}

Eigen::MatrixXd information_of(const ViewRows& rows) {
    const Eigen::MatrixXd across = rows.by_pose.transpose() * rows.by_mode;
    const Matrix6d own = rows.by_pose.transpose() * rows.by_pose;
    return rows.by_mode.transpose() * rows.by_mode - across.transpose() * own.ldlt().solve(across);
}

}  // namespace stria

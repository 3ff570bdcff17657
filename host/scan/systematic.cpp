#include "host/scan/systematic.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>

namespace stria {
namespace {

constexpr int kBasisSize = 20;  // all monomials of (u, v, s) up to degree 3
constexpr int kMaxModes = 8;    // beyond them the covariance adds nothing that can be seen

/// Square root L of a covariance, L L' = C, tolerant of singular ones: eigenvectors scaled.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        0.5 * (covariance + covariance.transpose()));
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

std::size_t index_of(const ScannerModel& model, const Channel& channel) {
    for (std::size_t i = 0; i < model.channels.size(); ++i)
        if (model.channels[i].camera_id == channel.camera_id &&
            model.channels[i].laser_id == channel.laser_id)
            return i;
    return 0;
}

/// Points of the samples under a model; NaN where a ray misses.
Eigen::Matrix3Xd points_under(const Channel& channel, std::span<const ScanSample> samples) {
    Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(samples.size()));
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const auto hit = triangulate(channel, samples[i].pixel, samples[i].s);
        points.col(static_cast<Eigen::Index>(i)) =
            hit ? hit->point_in_scan : Eigen::Vector3d::Constant(std::nan(""));
    }
    return points;
}

/// Removes from displacements (3 x n) at points (3 x n) the best infinitesimal rigid motion.
Eigen::Matrix3Xd without_rigid_motion(const Eigen::Matrix3Xd& points, Eigen::Matrix3Xd moved) {
    const Eigen::Vector3d mean_point = points.rowwise().mean();
    const Eigen::Vector3d mean_move = moved.rowwise().mean();
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    Eigen::Vector3d torque = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
        const Eigen::Vector3d arm = points.col(i) - mean_point;
        inertia += arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose();
        torque += arm.cross(moved.col(i) - mean_move);
    }
    const Eigen::Vector3d turn = inertia.ldlt().solve(torque);
    for (Eigen::Index i = 0; i < points.cols(); ++i)
        moved.col(i) -= mean_move + turn.cross(points.col(i) - mean_point);
    return moved;
}

}  // namespace

SystematicErrors::SystematicErrors(const ScannerModel& model, const Channel& channel,
                                   std::span<const ScanSample> samples) {
    if (model.covariance.size() == 0 || samples.size() < 2 * kBasisSize) return;
    const std::size_t which = index_of(model, channel);
    const Eigen::MatrixXd root = square_root(model.covariance);
    const auto count = static_cast<Eigen::Index>(samples.size());

    // Displacement of every sample by one standard deviation of each independent error.
    const Eigen::Matrix3Xd points = points_under(channel, samples);
    Eigen::MatrixXd along(count, root.cols());
    for (Eigen::Index mode = 0; mode < root.cols(); ++mode) {
        const auto plus = perturbed(model, root.col(mode)).channels[which];
        const auto minus = perturbed(model, -root.col(mode)).channels[which];
        Eigen::Matrix3Xd moved = 0.5 * (points_under(plus, samples) - points_under(minus, samples));
        moved = moved.array().isFinite().select(moved.array(), 0.0).matrix();
        moved = without_rigid_motion(points, std::move(moved));
        for (Eigen::Index i = 0; i < count; ++i)
            along(i, mode) = moved.col(i).dot(samples[static_cast<std::size_t>(i)].error_direction);
    }

    // Turn the errors so that the few first ones carry the most.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> leading(along.transpose() * along);
    const Eigen::Index modes = std::min<Eigen::Index>(kMaxModes, root.cols());
    const Eigen::MatrixXd turned =
        along * leading.eigenvectors().rightCols(modes).rowwise().reverse();

    Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
    for (const ScanSample& sample : samples) {
        const Eigen::Vector3d at(sample.pixel.x(), sample.pixel.y(), sample.s);
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
    }
    centre_ = 0.5 * (low + high);
    scale_ = (0.5 * (high - low)).cwiseMax(1e-12);
    Eigen::MatrixXd design(count, kBasisSize);
    for (Eigen::Index i = 0; i < count; ++i) {
        const ScanSample& sample = samples[static_cast<std::size_t>(i)];
        design.row(i) = basis(sample.pixel, sample.s).transpose();
    }
    coefficients_ = design.colPivHouseholderQr().solve(turned);
}

Eigen::VectorXd SystematicErrors::basis(const Eigen::Vector2d& pixel, double s) const {
    const Eigen::Vector3d x =
        (Eigen::Vector3d(pixel.x(), pixel.y(), s) - centre_).cwiseQuotient(scale_);
    Eigen::VectorXd terms(kBasisSize);
    int next = 0;
    double pu = 1;
    for (int i = 0; i <= 3; ++i, pu *= x[0]) {
        double pv = pu;
        for (int j = 0; i + j <= 3; ++j, pv *= x[1]) {
            double ps = pv;
            for (int k = 0; i + j + k <= 3; ++k, ps *= x[2]) terms[next++] = ps;
        }
    }
    return terms;
}

Eigen::VectorXd SystematicErrors::displacements(const Eigen::Vector2d& pixel, double s) const {
    if (coefficients_.size() == 0) return {};
    return coefficients_.transpose() * basis(pixel, s);
}

}  // namespace stria

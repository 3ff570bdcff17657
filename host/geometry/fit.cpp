#include "host/geometry/fit.h"

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace stria {
namespace {

void require_points(const char* who, std::size_t found, std::size_t needed) {
    if (found < needed)
        throw std::invalid_argument(std::string(who) + ": " + std::to_string(found) +
                                    " points, expected at least " + std::to_string(needed));
}

Eigen::Vector3d mean_of(std::span<const Eigen::Vector3d> points) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& point : points) sum += point;
    return sum / static_cast<double>(points.size());
}

/// Algebraic fit about `mean`: |p|^2 = 2 c.p + k is linear in (c, k). False if the points do not
/// determine it (coplanar, collinear).
bool algebraic_sphere(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& mean,
                      Eigen::Vector3d& centre, double& radius) {
    Eigen::MatrixX4d design(points.size(), 4);
    Eigen::VectorXd square(points.size());
    double scale = 0;
    for (const Eigen::Vector3d& point : points) scale = std::max(scale, (point - mean).norm());
    if (!(scale > 0) || !std::isfinite(scale)) return false;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Eigen::Vector3d p = (points[i] - mean) / scale;
        design.row(static_cast<Eigen::Index>(i)) << 2.0 * p.transpose(), 1.0;
        square(static_cast<Eigen::Index>(i)) = p.squaredNorm();
    }
    Eigen::ColPivHouseholderQR<Eigen::MatrixX4d> qr(design);
    qr.setThreshold(1e-9);  // flatter than a billionth of the size has no sphere
    if (qr.rank() < 4) return false;
    const Eigen::Vector4d solution = qr.solve(square);
    const double radius2 = solution(3) + solution.head<3>().squaredNorm();
    if (!(radius2 > 0)) return false;
    centre = mean + scale * solution.head<3>();
    radius = scale * std::sqrt(radius2);
    return true;
}

/// Gauss-Newton on the distances from the sphere, from `fit` on; the last of the 4 parameters, the
/// radius, stays where it is unless `free_radius`.
void refine_sphere(std::span<const Eigen::Vector3d> points, bool free_radius, SphereFit& fit) {
    constexpr int kRounds = 100;
    for (int round = 0; round < kRounds && !fit.converged; ++round) {
        Eigen::Matrix4d normal_matrix = Eigen::Matrix4d::Zero();
        Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
        for (const Eigen::Vector3d& point : points) {
            const Eigen::Vector3d offset = point - fit.centre;
            const double distance = offset.norm();
            if (!(distance > 0)) continue;
            Eigen::Vector4d row;  // of the residual distance - radius
            row << -offset / distance, free_radius ? -1.0 : 0.0;
            normal_matrix += row * row.transpose();
            gradient += row * (distance - fit.radius_mm);
        }
        if (!free_radius) normal_matrix(3, 3) = 1;
        const Eigen::Vector4d step = normal_matrix.ldlt().solve(-gradient);
        if (!step.allFinite()) break;
        fit.centre += step.head<3>();
        fit.radius_mm += step(3);
        fit.converged = step.norm() < 1e-12 * (1.0 + std::abs(fit.radius_mm));
    }
    double sum = 0;
    for (const Eigen::Vector3d& point : points)
        sum += std::pow((point - fit.centre).norm() - fit.radius_mm, 2);
    fit.rms_mm = std::sqrt(sum / static_cast<double>(points.size()));
    fit.converged = fit.converged && fit.radius_mm > 0;
}

}  // namespace

PlaneFit fit_plane(std::span<const Eigen::Vector3d> points) {
    require_points("fit_plane", points.size(), 3);
    const Eigen::Vector3d mean = mean_of(points);
    Eigen::MatrixX3d centred(points.size(), 3);
    for (std::size_t i = 0; i < points.size(); ++i)
        centred.row(static_cast<Eigen::Index>(i)) = (points[i] - mean).transpose();
    // The SVD of R is that of the points, without squaring their condition.
    const Eigen::Matrix3d r = Eigen::HouseholderQR<Eigen::MatrixX3d>(centred)
                                  .matrixQR()
                                  .topRows<3>()
                                  .triangularView<Eigen::Upper>();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullV);
    PlaneFit fit;
    fit.normal = svd.matrixV().col(2);
    fit.offset_mm = fit.normal.dot(mean);
    fit.singular_values = svd.singularValues();
    fit.rms_mm = (centred * fit.normal).norm() / std::sqrt(static_cast<double>(points.size()));
    return fit;
}

SphereFit fit_sphere(std::span<const Eigen::Vector3d> points) {
    require_points("fit_sphere", points.size(), 4);
    SphereFit fit;
    if (algebraic_sphere(points, mean_of(points), fit.centre, fit.radius_mm))
        refine_sphere(points, true, fit);
    else
        fit.rms_mm = std::numeric_limits<double>::quiet_NaN();
    return fit;
}

SphereFit fit_sphere_of_radius(std::span<const Eigen::Vector3d> points, double radius_mm) {
    require_points("fit_sphere_of_radius", points.size(), 4);
    if (!(radius_mm > 0) || !std::isfinite(radius_mm))
        throw std::invalid_argument("fit_sphere_of_radius: radius_mm " + std::to_string(radius_mm) +
                                    ", expected above 0");
    SphereFit fit;
    if (!algebraic_sphere(points, mean_of(points), fit.centre, fit.radius_mm)) {
        fit.rms_mm = std::numeric_limits<double>::quiet_NaN();
        return fit;
    }
    fit.radius_mm = radius_mm;
    refine_sphere(points, false, fit);
    return fit;
}

}  // namespace stria

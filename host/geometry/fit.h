#pragma once
#include <Eigen/Core>
#include <span>

namespace stria {

struct PlaneFit {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
    double offset_mm = 0;  ///< normal . p = offset_mm
    double rms_mm = 0;
    Eigen::Vector3d singular_values = Eigen::Vector3d::Zero();  ///< of the centred points
};
/// Orthogonal least squares, at least 3 points (std::invalid_argument otherwise).
PlaneFit fit_plane(std::span<const Eigen::Vector3d> points);

struct SphereFit {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double radius_mm = 0;
    double rms_mm = 0;
    bool converged = false;
};
/// Geometric least squares (Gauss-Newton from the algebraic fit), at least 4 points.
SphereFit fit_sphere(std::span<const Eigen::Vector3d> points);

/// The same with the radius given (mm, > 0; std::invalid_argument otherwise): only the centre is
/// sought, from the algebraic fit's on.
SphereFit fit_sphere_of_radius(std::span<const Eigen::Vector3d> points, double radius_mm);

}  // namespace stria

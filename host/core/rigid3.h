#pragma once
#include <Eigen/Core>

namespace stria {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// A rigid motion, named so that names cancel: p_in_world = world_from_scan * p_in_scan.
struct Rigid3 {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< mm

    Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
        return rotation * point + translation;
    }
    Rigid3 operator*(const Rigid3& other) const {
        return {rotation * other.rotation, rotation * other.translation + translation};
    }
    Rigid3 inverse() const { return {rotation.transpose(), -(rotation.transpose() * translation)}; }
};

/// Rotation by |w| rad about w (Rodrigues).
Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w);
/// The inverse, |w| <= pi.
Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& rotation);

/// {rotation_from_vector(delta.head<3>()), delta.tail<3>()}: order rx ry rz (rad) tx ty tz (mm).
/// A pose's covariance is that of delta in true = rigid_from_vector(delta) * estimate.
Rigid3 rigid_from_vector(const Vector6d& delta);
Vector6d vector_from_rigid(const Rigid3& motion);

/// Nearest rotation matrix to a slightly disturbed one (SVD).
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

/// True if rotation' rotation = 1 within `tolerance`, determinant positive, all finite.
bool is_rigid(const Rigid3& motion, double tolerance = 1e-6);

}  // namespace stria

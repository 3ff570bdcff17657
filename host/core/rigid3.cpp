#include "host/core/rigid3.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace stria {

Eigen::Matrix3d rotation_from_vector(const Eigen::Vector3d& w) {
    const double angle = w.norm();
    if (angle < 1e-300) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
}

Eigen::Vector3d vector_from_rotation(const Eigen::Matrix3d& rotation) {
    Eigen::Quaterniond q(rotation);
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const double sin_half = q.vec().norm();
    if (sin_half < 1e-300) return Eigen::Vector3d::Zero();
    return q.vec() * (2.0 * std::atan2(sin_half, q.w()) / sin_half);
}

Rigid3 rigid_from_vector(const Vector6d& delta) {
    return {rotation_from_vector(delta.head<3>()), delta.tail<3>()};
}

Vector6d vector_from_rigid(const Rigid3& motion) {
    Vector6d delta;
    delta << vector_from_rotation(motion.rotation), motion.translation;
    return delta;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix) {
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
    return u * svd.matrixV().transpose();
}

bool is_rigid(const Rigid3& motion, double tolerance) {
    return motion.rotation.allFinite() && motion.translation.allFinite() &&
           (motion.rotation.transpose() * motion.rotation - Eigen::Matrix3d::Identity()).norm() <
               tolerance &&
           motion.rotation.determinant() > 0;
}

}  // namespace stria

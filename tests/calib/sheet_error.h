#pragma once
#include <Eigen/Dense>
#include <Eigen/Geometry>

#include "tests/calib/photographed_board.h"

namespace stria {

/// A measured sheet's error in the units of its own covariance, that of (normal, offset_mm):
/// chi-square with 3 degrees of freedom if the covariance is true.
inline double sheet_chi_square(const Eigen::Vector3d& normal, double offset_mm,
                               const Eigen::Matrix4d& covariance, const FlatSheet& truth) {
    const Eigen::Vector3d a = truth.normal.unitOrthogonal(), b = truth.normal.cross(a);
    Eigen::Matrix<double, 3, 4> rows = Eigen::Matrix<double, 3, 4>::Zero();
    rows.row(0).head<3>() = a;
    rows.row(1).head<3>() = b;
    rows(2, 3) = 1;
    Eigen::Vector4d error;
    error << normal - truth.normal, offset_mm - truth.offset_mm;
    const Eigen::Vector3d off = rows * error;
    return off.dot((rows * covariance * rows.transpose()).inverse() * off);
}

inline double angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace stria

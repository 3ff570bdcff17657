#pragma once
#include <ceres/problem.h>

#include <Eigen/Core>
#include <vector>

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

/// Information matrix (inverse covariance) of the shared parameter blocks of a problem in which
/// every residual touches shared blocks and at most one of the `separate` ones: J'J with the
/// separate blocks eliminated (their uncertainty included). Order and tangent sizes as the shared
/// blocks are given; the problem must hold every block listed, and loss functions are not applied.
/// Residuals must be whitened for the result to mean what it says.
Eigen::MatrixXd schur_information(ceres::Problem& problem, const std::vector<double*>& shared,
                                  const std::vector<double*>& separate);

}  // namespace stria

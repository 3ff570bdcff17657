#pragma once
#include <ceres/crs_matrix.h>
#include <ceres/problem.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

/// Normal equations of a problem in which every residual touches shared parameter blocks and at
/// most one separate one (a pose): J'J has the shape of an arrow. Columns are tangents: first the
/// shared blocks in the order given, then the separate ones.
class ArrowSystem {
  public:
    /// @param jacobian  evaluated over `shared`, then `separate`: blocks of the problem, none held
    ///                  as a whole
    ArrowSystem(const ceres::Problem& problem, const std::vector<double*>& shared,
                const std::vector<double*>& separate, const ceres::CRSMatrix& jacobian);

    /// J'J of the shared blocks with the separate ones eliminated.
    const Eigen::MatrixXd& schur_complement() const { return left_; }
    /// x of J'J x = right.
    Eigen::VectorXd solve(const Eigen::VectorXd& right) const;
    /// The directions e of the shared blocks, scaled to a unit diagonal, that the residuals see
    /// least, with what the separate blocks then follow: one a column, each with e'J'J e = 1.
    Eigen::MatrixXd weakest(int count) const;

  private:
    void add(const ceres::CRSMatrix& jacobian);
    /// The shared part given, with the separate one that solves its own equations.
    Eigen::VectorXd follow(const Eigen::VectorXd& shared, const Eigen::VectorXd& right) const;

    std::vector<int> separate_of_column_;  ///< -1: shared
    std::vector<int> first_column_;        ///< of each separate block
    Eigen::MatrixXd shared_;
    std::vector<Eigen::MatrixXd> across_;  ///< shared rows, the separate block's columns
    std::vector<Eigen::MatrixXd> own_;
    std::vector<Eigen::LDLT<Eigen::MatrixXd>> own_factor_;
    Eigen::MatrixXd left_;
};

}  // namespace stria

#include "calib/arrow_system.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace stria {
namespace {

/// Takes millimetres and mirror gains, side by side in a matrix, to a unit diagonal.
Eigen::VectorXd unit_scale(const Eigen::MatrixXd& matrix) {
    return matrix.diagonal().cwiseSqrt().cwiseInverse();
}

}  // namespace

ArrowSystem::ArrowSystem(const ceres::Problem& problem, const std::vector<double*>& shared,
                         const std::vector<double*>& separate, const ceres::CRSMatrix& jacobian) {
    int column = 0;
    for (double* block : shared) column += problem.ParameterBlockTangentSize(block);
    shared_ = Eigen::MatrixXd::Zero(column, column);
    separate_of_column_.assign(static_cast<std::size_t>(jacobian.num_cols), -1);
    for (std::size_t i = 0; i < separate.size(); ++i) {
        const int size = problem.ParameterBlockTangentSize(separate[i]);
        first_column_.push_back(column);
        for (int k = 0; k < size; ++k)
            separate_of_column_[static_cast<std::size_t>(column++)] = static_cast<int>(i);
        across_.push_back(Eigen::MatrixXd::Zero(shared_.rows(), size));
        own_.push_back(Eigen::MatrixXd::Zero(size, size));
    }
    add(jacobian);
    left_ = shared_;
    for (std::size_t b = 0; b < own_.size(); ++b) {
        own_factor_.emplace_back(own_[b]);
        left_ -= across_[b] * own_factor_[b].solve(across_[b].transpose());
    }
    left_ = 0.5 * (left_ + left_.transpose()).eval();
}

void ArrowSystem::add(const ceres::CRSMatrix& jacobian) {
    for (int row = 0; row < jacobian.num_rows; ++row) {
        const int begin = jacobian.rows[static_cast<std::size_t>(row)];
        const int end = jacobian.rows[static_cast<std::size_t>(row) + 1];
        for (int i = begin; i < end; ++i) {
            const int ci = jacobian.cols[static_cast<std::size_t>(i)];
            const double vi = jacobian.values[static_cast<std::size_t>(i)];
            const int bi = separate_of_column_[static_cast<std::size_t>(ci)];
            for (int j = begin; j < end; ++j) {
                const int cj = jacobian.cols[static_cast<std::size_t>(j)];
                const int bj = separate_of_column_[static_cast<std::size_t>(cj)];
                const double product = vi * jacobian.values[static_cast<std::size_t>(j)];
                if (bi < 0 && bj < 0) {
                    shared_(ci, cj) += product;
                } else if (bi < 0) {
                    const auto b = static_cast<std::size_t>(bj);
                    across_[b](ci, cj - first_column_[b]) += product;
                } else if (bj == bi) {
                    const auto b = static_cast<std::size_t>(bi);
                    own_[b](ci - first_column_[b], cj - first_column_[b]) += product;
                }
            }
        }
    }
}

Eigen::VectorXd ArrowSystem::follow(const Eigen::VectorXd& shared,
                                    const Eigen::VectorXd& right) const {
    Eigen::VectorXd x(right.size());
    x.head(shared.size()) = shared;
    for (std::size_t b = 0; b < own_.size(); ++b) {
        const Eigen::Index at = first_column_[b], count = own_[b].rows();
        x.segment(at, count) =
            own_factor_[b].solve(right.segment(at, count) - across_[b].transpose() * shared);
    }
    return x;
}

Eigen::VectorXd ArrowSystem::solve(const Eigen::VectorXd& right) const {
    Eigen::VectorXd head = right.head(shared_.rows());
    for (std::size_t b = 0; b < own_.size(); ++b)
        head -= across_[b] * own_factor_[b].solve(right.segment(first_column_[b], own_[b].rows()));
    const Eigen::VectorXd scale = unit_scale(left_);
    const Eigen::LDLT<Eigen::MatrixXd> scaled(
        Eigen::MatrixXd(scale.asDiagonal() * left_ * scale.asDiagonal()));
    return follow(scale.asDiagonal() * scaled.solve(scale.asDiagonal() * head), right);
}

Eigen::MatrixXd ArrowSystem::weakest(int count) const {
    const Eigen::VectorXd scale = unit_scale(left_);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        Eigen::MatrixXd(scale.asDiagonal() * left_ * scale.asDiagonal()));
    const auto size = static_cast<Eigen::Index>(separate_of_column_.size());
    Eigen::MatrixXd weak(size, count);
    for (int i = 0; i < count; ++i)
        weak.col(i) = follow(scale.asDiagonal() * eigen.eigenvectors().col(i) /
                                 std::sqrt(std::max(eigen.eigenvalues()[i], 1e-14)),
                             Eigen::VectorXd::Zero(size));
    return weak;
}

}  // namespace stria

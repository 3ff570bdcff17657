#include "calib/schur_information.h"

#include <ceres/crs_matrix.h>

#include <Eigen/Cholesky>

namespace stria {
namespace {

/// Adds the row's products within and between shared columns [0, shared) and one separate block.
struct Blocks {
    Eigen::MatrixXd shared;               ///< A
    std::vector<Eigen::MatrixXd> across;  ///< B_i, shared x separate_i
    std::vector<Eigen::MatrixXd> own;     ///< D_i
};

}  // namespace

Eigen::MatrixXd schur_information(ceres::Problem& problem, const std::vector<double*>& shared,
                                  const std::vector<double*>& separate) {
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = shared;
    options.parameter_blocks.insert(options.parameter_blocks.end(), separate.begin(),
                                    separate.end());
    options.apply_loss_function = false;
    ceres::CRSMatrix jacobian;
    problem.Evaluate(options, nullptr, nullptr, nullptr, &jacobian);

    int shared_size = 0;
    for (double* block : shared) shared_size += problem.ParameterBlockTangentSize(block);
    std::vector<int> block_of_column(static_cast<std::size_t>(jacobian.num_cols), -1);
    std::vector<int> first_column;
    Blocks sums;
    sums.shared = Eigen::MatrixXd::Zero(shared_size, shared_size);
    int column = shared_size;
    for (std::size_t i = 0; i < separate.size(); ++i) {
        const int size = problem.ParameterBlockTangentSize(separate[i]);
        first_column.push_back(column);
        for (int k = 0; k < size; ++k)
            block_of_column[static_cast<std::size_t>(column++)] = static_cast<int>(i);
        sums.across.push_back(Eigen::MatrixXd::Zero(shared_size, size));
        sums.own.push_back(Eigen::MatrixXd::Zero(size, size));
    }

    for (int row = 0; row < jacobian.num_rows; ++row) {
        const int begin = jacobian.rows[static_cast<std::size_t>(row)];
        const int end = jacobian.rows[static_cast<std::size_t>(row) + 1];
        for (int i = begin; i < end; ++i) {
            const int ci = jacobian.cols[static_cast<std::size_t>(i)];
            const double vi = jacobian.values[static_cast<std::size_t>(i)];
            const int bi = block_of_column[static_cast<std::size_t>(ci)];
            for (int j = begin; j < end; ++j) {
                const int cj = jacobian.cols[static_cast<std::size_t>(j)];
                const int bj = block_of_column[static_cast<std::size_t>(cj)];
                const double product = vi * jacobian.values[static_cast<std::size_t>(j)];
                if (bi < 0 && bj < 0) {
                    sums.shared(ci, cj) += product;
                } else if (bi < 0) {
                    const auto b = static_cast<std::size_t>(bj);
                    sums.across[b](ci, cj - first_column[b]) += product;
                } else if (bj == bi) {
                    const auto b = static_cast<std::size_t>(bi);
                    sums.own[b](ci - first_column[b], cj - first_column[b]) += product;
                }
            }
        }
    }
    for (std::size_t b = 0; b < separate.size(); ++b)
        sums.shared -= sums.across[b] * sums.own[b].ldlt().solve(sums.across[b].transpose());
    return 0.5 * (sums.shared + sums.shared.transpose());
}

}  // namespace stria

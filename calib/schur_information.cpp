#include "calib/schur_information.h"

#include "calib/arrow_system.h"

namespace stria {

Eigen::MatrixXd schur_information(ceres::Problem& problem, const std::vector<double*>& shared,
                                  const std::vector<double*>& separate) {
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = shared;
    options.parameter_blocks.insert(options.parameter_blocks.end(), separate.begin(),
                                    separate.end());
    options.apply_loss_function = false;
    ceres::CRSMatrix jacobian;
    problem.Evaluate(options, nullptr, nullptr, nullptr, &jacobian);
    return ArrowSystem(problem, shared, separate, jacobian).schur_complement();
}

}  // namespace stria

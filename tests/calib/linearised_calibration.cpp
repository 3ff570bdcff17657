#include "tests/calib/linearised_calibration.h"

#include <Eigen/Cholesky>

#include "calib/camera_cost.h"
#include "calib/stripe_points.h"

namespace stria {
namespace {

bool is_free(const std::string& name) {
    for (const char* held : {"axis.delay", "table.rz", "table.tz"})
        if (name.find(held) != std::string::npos) return false;
    return true;
}

}  // namespace

ScannerProblem problem_at_truth(const ScannerModel& truth, const Board& board,
                                const std::vector<CornerView>& views,
                                const std::vector<Rigid3>& poses, double corner_noise_px,
                                const ScannerCalibrationOptions& options) {
    ScannerProblem problem(board, truth.channels, options);
    const BoardColours colours(board);
    for (std::size_t v = 0; v < views.size(); ++v) {
        ScannerProblem::View view;
        view.pose = pose_block(poses[v]);
        for (const BoardCorners& seen : views[v].corners)
            for (std::size_t i = 0; i < seen.ids.size(); ++i)
                view.corners.push_back({seen.ids[i], seen.pixels[i], seen.s});
        for (const StripePoint& point :
             stripe_points_on_board(views[v].pulses, truth.channels[0], poses[v], colours,
                                    options.stripe_points_per_view))
            view.stripes.push_back({point});
        problem.views.push_back(std::move(view));
    }
    problem.weigh_stripes();
    problem.corner_sigma_px = corner_noise_px;
    problem.stripe_sigma_factor = 1;
    return problem;
}

Eigen::VectorXd LinearisedCalibration::residuals(const ScannerProblem& problem,
                                                 const ScannerProblem::View& view) const {
    Eigen::VectorXd all(2 * Eigen::Index(view.corners.size()) + Eigen::Index(view.stripes.size()));
    Eigen::Index row = 0;
    for (const auto& corner : view.corners) {
        all.segment<2>(row) = problem.residual(view, corner) / problem.corner_sigma_px;
        row += 2;
    }
    for (const auto& stripe : view.stripes)
        all[row++] = problem.residual_mm(view, stripe) / stripe.sigma_mm;
    return all;
}

LinearisedCalibration::LinearisedCalibration(const ScannerModel& truth, const Board& board,
                                             const ScannerProblem& at_truth,
                                             const ScannerCalibrationOptions& options)
    : problem_(at_truth) {
    const auto names = parameter_names(truth);
    for (std::size_t i = 0; i < names.size(); ++i)
        if (is_free(names[i])) free_.push_back(static_cast<Eigen::Index>(i));
    const auto count = static_cast<Eigen::Index>(free_.size());
    prior_weight_ = Eigen::VectorXd(count);
    const Eigen::VectorXd sigmas = building_sigma(truth);
    // The problems of the truth moved by one small step up and down in each free parameter.
    std::vector<ScannerProblem> up, down;
    std::vector<double> steps;
    for (Eigen::Index i = 0; i < count; ++i) {
        const Eigen::Index name = free_[static_cast<std::size_t>(i)];
        const bool of_camera =
            names[static_cast<std::size_t>(name)].find(".camera.") != std::string::npos;
        prior_weight_[i] = of_camera ? 0 : 1 / sigmas[name];
        Eigen::VectorXd delta = Eigen::VectorXd::Zero(Eigen::Index(names.size()));
        delta[name] = 1e-3 * sigmas[name];
        steps.push_back(delta[name]);
        up.emplace_back(board, perturbed(truth, delta).channels, options);
        down.emplace_back(board, perturbed(truth, -delta).channels, options);
        up.back().corner_sigma_px = down.back().corner_sigma_px = problem_.corner_sigma_px;
    }
    Eigen::MatrixXd information = Eigen::MatrixXd(prior_weight_.cwiseAbs2().asDiagonal());
    for (const ScannerProblem::View& view : problem_.views) {
        const Eigen::Index rows = residuals(problem_, view).size();
        Eigen::MatrixXd shared(rows, count), pose(rows, 6);
        for (Eigen::Index i = 0; i < count; ++i) {
            const auto k = static_cast<std::size_t>(i);
            shared.col(i) = (residuals(up[k], view) - residuals(down[k], view)) / (2 * steps[k]);
        }
        for (int i = 0; i < 6; ++i) {
            const double h = i < 3 ? 1e-6 : 1e-3;  // rad, mm
            ScannerProblem::View after = view, before = view;
            after.pose[i] += h;
            before.pose[i] -= h;
            pose.col(i) = (residuals(problem_, after) - residuals(problem_, before)) / (2 * h);
        }
        const Eigen::MatrixXd own = pose.transpose() * pose;
        reduced_.push_back(shared - pose * own.ldlt().solve(pose.transpose() * shared));
        information += reduced_.back().transpose() * reduced_.back();
    }
    const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
    covariance_ = scale.asDiagonal() *
                  (scale.asDiagonal() * information * scale.asDiagonal())
                      .ldlt()
                      .solve(Eigen::MatrixXd::Identity(count, count)) *
                  scale.asDiagonal();
}

Eigen::VectorXd LinearisedCalibration::errors_of_a_trial(std::mt19937& rng) const {
    std::normal_distribution<double> unit(0, 1);
    Eigen::VectorXd pull(prior_weight_.size());
    for (Eigen::Index i = 0; i < pull.size(); ++i) pull[i] = unit(rng) * prior_weight_[i];
    for (std::size_t v = 0; v < problem_.views.size(); ++v) {
        ScannerProblem::View noisy = problem_.views[v];
        for (auto& corner : noisy.corners)
            corner.pixel += problem_.corner_sigma_px * Eigen::Vector2d(unit(rng), unit(rng));
        for (auto& stripe : noisy.stripes)
            (stripe.point.mode == StripeMode::spacetime ? stripe.point.s
                                                        : stripe.point.pixel.x()) +=
                stripe.point.sigma * unit(rng);
        pull -= reduced_[v].transpose() * residuals(problem_, noisy);
    }
    return covariance_ * pull;
}

}  // namespace stria

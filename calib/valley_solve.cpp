#include "calib/valley_solve.h"

#include <ceres/manifold.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>

#include "calib/arrow_system.h"

namespace stria {
namespace {

constexpr double kPromise = 1e-3;        // half chi-square: less is not worth a step
constexpr int kMostWeak = 3;             // directions of true second derivatives, or a third of all
constexpr double kProbe = 0.01;          // of a direction: where its second derivative is taken
constexpr double kLeastCurvature = 0.1;  // of Gauss and Newton's
constexpr double kLeastShare = 1e-4;     // of a step
constexpr double kLeastGain = 1e-4;      // of what the slope promises (Armijo)

/// The problem's moving blocks as one vector, its residuals and their Jacobian there.
class Floor {
  public:
    Floor(ceres::Problem& problem, const std::vector<double*>& shared,
          const std::vector<double*>& separate)
        : problem_(problem) {
        const auto moving = [&](const std::vector<double*>& all) {
            std::vector<double*> kept;
            for (double* block : all)
                if (problem.HasParameterBlock(block) && !problem.IsParameterBlockConstant(block))
                    kept.push_back(block);
            return kept;
        };
        shared_ = moving(shared);
        separate_ = moving(separate);
        options_.parameter_blocks = shared_;
        options_.parameter_blocks.insert(options_.parameter_blocks.end(), separate_.begin(),
                                         separate_.end());
        settle();
    }

    /// The blocks as they are become what step() starts from.
    void settle() {
        start_.clear();
        for (const double* block : options_.parameter_blocks)
            start_.insert(start_.end(), block, block + problem_.ParameterBlockSize(block));
        problem_.Evaluate(options_, &cost_, &residuals_, nullptr, &jacobian_);
    }
    void step(const Eigen::VectorXd& by) {
        const double *kept = start_.data(), *delta = by.data();
        for (double* block : options_.parameter_blocks) {
            const int size = problem_.ParameterBlockSize(block);
            if (const ceres::Manifold* manifold = problem_.GetManifold(block))
                manifold->Plus(kept, delta, block);
            else
                std::transform(kept, kept + size, delta, block, std::plus<>());
            kept += size;
            delta += problem_.ParameterBlockTangentSize(block);
        }
    }
    void step_back() { step(Eigen::VectorXd::Zero(jacobian_.num_cols)); }

    double cost() const { return cost_; }
    ArrowSystem system() const { return {problem_, shared_, separate_, jacobian_}; }
    int shared_count() const {
        int count = 0;
        for (const double* block : shared_) count += problem_.ParameterBlockTangentSize(block);
        return count;
    }
    /// J'r with the start's J.
    Eigen::VectorXd along(const Eigen::VectorXd& residuals) const {
        Eigen::VectorXd sum = Eigen::VectorXd::Zero(jacobian_.num_cols);
        for_each([&](int row, int column, double value) { sum[column] += value * residuals[row]; });
        return sum;
    }
    Eigen::VectorXd start_gradient() const { return along(as_vector(residuals_)); }

    // Where step() went:
    /// @return the cost, infinite where a residual cannot be had
    double evaluate(Eigen::VectorXd* residuals = nullptr) {
        double cost = 0;
        std::vector<double> values;
        if (!problem_.Evaluate(options_, &cost, &values, nullptr, nullptr)) return HUGE_VAL;
        if (residuals) *residuals = as_vector(values);
        return cost;
    }
    /// J x + residuals, of the start.
    Eigen::VectorXd linear(const Eigen::VectorXd& x) const {
        Eigen::VectorXd sum = as_vector(residuals_);
        for_each([&](int row, int column, double value) { sum[row] += value * x[column]; });
        return sum;
    }
    /// Second derivative of the residuals along v; zero if they cannot be had a little on.
    Eigen::VectorXd bend_along(const Eigen::VectorXd& v) {
        Eigen::VectorXd bend;
        step(kProbe * v);
        if (!(evaluate(&bend) < HUGE_VAL)) return Eigen::VectorXd::Zero(jacobian_.num_rows);
        return 2 / (kProbe * kProbe) * (bend - linear(kProbe * v));
    }

  private:
    static Eigen::VectorXd as_vector(const std::vector<double>& values) {
        return Eigen::Map<const Eigen::VectorXd>(values.data(),
                                                 static_cast<Eigen::Index>(values.size()));
    }
    template <typename Use>
    void for_each(const Use& use) const {
        for (int row = 0; row < jacobian_.num_rows; ++row)
            for (int i = jacobian_.rows[static_cast<std::size_t>(row)];
                 i < jacobian_.rows[static_cast<std::size_t>(row) + 1]; ++i)
                use(row, jacobian_.cols[static_cast<std::size_t>(i)],
                    jacobian_.values[static_cast<std::size_t>(i)]);
    }

    ceres::Problem& problem_;
    std::vector<double*> shared_, separate_;
    ceres::Problem::EvaluateOptions options_;
    std::vector<double> start_, residuals_;
    ceres::CRSMatrix jacobian_;
    double cost_ = 0;
};

/// Inverse of J'J, but along the weakest directions E (E'J'J E = 1) of the cost's true second
/// derivatives on the floor, C = 1 + r . r'' with the part of the residuals r taken out that the
/// first step removes: (J'J)^-1 + E (C^-1 - 1) E', C made positive.
class Newton {
  public:
    explicit Newton(Floor& floor)
        : system_(floor.system()),
          weak_(system_.weakest(std::min(kMostWeak, (floor.shared_count() + 2) / 3))) {
        const Eigen::VectorXd left = floor.linear(-system_.solve(floor.start_gradient()));
        const auto count = weak_.cols();
        Eigen::MatrixXd curvature(count, count);
        for (Eigen::Index i = 0; i < count; ++i)
            curvature(i, i) = left.dot(floor.bend_along(weak_.col(i)));
        for (Eigen::Index i = 0; i < count; ++i)
            for (Eigen::Index j = 0; j < i; ++j) {
                const double both = left.dot(floor.bend_along(weak_.col(i) + weak_.col(j)));
                curvature(i, j) = curvature(j, i) =
                    0.5 * (both - curvature(i, i) - curvature(j, j));
            }
        curvature += Eigen::MatrixXd::Identity(count, count);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(curvature);
        const Eigen::VectorXd upward = eigen.eigenvalues().cwiseAbs().cwiseMax(kLeastCurvature);
        weak_inverse_ = eigen.eigenvectors() * upward.cwiseInverse().asDiagonal() *
                        eigen.eigenvectors().transpose();
        if (eigen.eigenvalues()[0] < -kLeastCurvature)
            over_the_top_ = weak_ * eigen.eigenvectors().col(0);
    }
    /// The step down the slope; where the cost curves downwards, no shorter than one unit that way.
    Eigen::VectorXd step(const Eigen::VectorXd& down) const {
        Eigen::VectorXd v = solve(down);
        if (is_over_a_top()) v += over_the_top_ * (down.dot(over_the_top_) < 0 ? -1 : 1);
        return v;
    }
    bool is_over_a_top() const { return over_the_top_.size() > 0; }
    /// By J'J alone.
    Eigen::VectorXd straight(const Eigen::VectorXd& right) const { return system_.solve(right); }
    Eigen::VectorXd solve(const Eigen::VectorXd& right) const {
        return strong(right) + weak_ * (weak_inverse_ * (weak_.transpose() * right));
    }
    /// Without the weak directions.
    Eigen::VectorXd strong(const Eigen::VectorXd& right) const {
        return system_.solve(right) - weak_ * (weak_.transpose() * right);
    }

  private:
    ArrowSystem system_;
    Eigen::MatrixXd weak_, weak_inverse_;
    Eigen::VectorXd over_the_top_;  ///< where the cost curves downwards most; empty: nowhere
};

/// Goes to a lower cost on the parabola of a Newton step; false if there is none.
bool follow(Floor& floor, const Newton& newton, const Eigen::VectorXd& v, double slope) {
    const Eigen::VectorXd a = -newton.straight(floor.along(floor.bend_along(v)));
    for (double t = 1; t > kLeastShare; t /= 2) {
        const double goal = floor.cost() - kLeastGain * t * slope;
        const Eigen::VectorXd ahead = t * v + 0.5 * t * t * a;
        Eigen::VectorXd residuals;
        floor.step(ahead);
        const double there = floor.evaluate(&residuals);
        if (!(there < HUGE_VAL)) continue;
        floor.step(ahead - newton.strong(floor.along(residuals)));
        if (const double on_floor = floor.evaluate(); on_floor < std::min(there, goal)) return true;
        floor.step(ahead);
        if (there < goal) return true;
    }
    return false;
}

}  // namespace

SolveEnd valley_solve(ceres::Problem& problem, const std::vector<double*>& shared,
                      const std::vector<double*>& separate, int max_iterations) {
    Floor floor(problem, shared, separate);
    SolveEnd end;
    end.initial_cost = floor.cost();
    while (true) {
        const Newton newton(floor);
        const Eigen::VectorXd down = -floor.start_gradient();
        const Eigen::VectorXd v = newton.step(down);
        const double slope = down.dot(v);
        end.converged = 0.5 * slope < kPromise && !newton.is_over_a_top();
        if (end.converged || end.iterations == max_iterations || !follow(floor, newton, v, slope))
            break;
        floor.settle();
        ++end.iterations;
    }
    floor.step_back();
    end.final_cost = floor.cost();
    return end;
}

}  // namespace stria

#include "calib/corner_noise.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>

namespace stria {
namespace {

constexpr double kWeakest = 1e-14;  ///< of the unit-diagonal information
constexpr double kShares[] = {0, 0.1, 0.3, 0.6, 0.9, 0.999};
constexpr int kSections = 5;  ///< golden ones: 6 % of the interval is left
constexpr double kReaches[] = {0.7, 1.4, 2.8, 5.6, 11.2};  ///< pitches

/// Inverse and log of the determinant of an information matrix, its weakest directions capped.
struct Inverted {
    Eigen::MatrixXd inverse;
    double log_determinant = 0;
};

Inverted inverted(const Eigen::MatrixXd& information) {
    const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
        Eigen::MatrixXd(scale.asDiagonal() * information * scale.asDiagonal()));
    const Eigen::VectorXd strength = eigen.eigenvalues().cwiseMax(kWeakest);
    const Eigen::MatrixXd vectors = scale.asDiagonal() * eigen.eigenvectors();
    return {vectors * strength.cwiseInverse().asDiagonal() * vectors.transpose(),
            strength.array().log().sum() - 2 * scale.array().log().sum()};
}

/// Both halves of the rows through the inverse of the correlation's lower factor.
Eigen::MatrixXd whitened(const Eigen::LLT<Eigen::MatrixXd>& factor, const Eigen::MatrixXd& rows) {
    const Eigen::Index half = rows.rows() / 2;
    Eigen::MatrixXd result = rows;
    factor.matrixL().solveInPlace(result.topRows(half));
    factor.matrixL().solveInPlace(result.bottomRows(half));
    return result;
}

/// What a noise of that shape makes of the residuals.
struct Likelihood {
    double minus_two_log = 0;
    double sigma = 0;
};

Likelihood likelihood(const std::vector<CornerRows>& views, double shared, double reach) {
    const CornerNoise noise{1, shared, reach};
    const Eigen::Index parameters = views.front().by_shared.cols();
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(parameters, parameters);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(parameters);
    double squares = 0, log_determinant = 0;
    Eigen::Index degrees = -parameters;
    for (const CornerRows& view : views) {
        const Eigen::LLT<Eigen::MatrixXd> factor(corner_correlation(view.on_board, noise));
        const Eigen::MatrixXd by_shared = whitened(factor, view.by_shared);
        const Eigen::MatrixXd by_pose = whitened(factor, view.by_pose);
        const Eigen::VectorXd residual = whitened(factor, view.residual);
        const Inverted pose = inverted(by_pose.transpose() * by_pose);
        const Eigen::MatrixXd across = by_pose.transpose() * by_shared;
        const Eigen::VectorXd own = by_pose.transpose() * residual;
        information +=
            by_shared.transpose() * by_shared - across.transpose() * pose.inverse * across;
        gradient += by_shared.transpose() * residual - across.transpose() * (pose.inverse * own);
        squares += residual.squaredNorm() - own.dot(pose.inverse * own);
        // twice for x and y, twice for the square of the factor's diagonal
        const Eigen::MatrixXd lower = factor.matrixL();
        log_determinant += 4 * lower.diagonal().array().log().sum() + pose.log_determinant;
        degrees += residual.size() - by_pose.cols();
    }
    const Inverted rest = inverted(information);
    squares -= gradient.dot(rest.inverse * gradient);
    if (degrees <= 0 || !(squares > 0)) return {};
    const double count = static_cast<double>(degrees);
    return {count * std::log(squares / count) + log_determinant + rest.log_determinant,
            std::sqrt(squares / count)};
}

/// Where between two places a function with one valley is least, by golden sections.
template <typename Function>
double least_between(double low, double high, const Function& function) {
    const double golden = 0.5 * (std::sqrt(5.0) - 1);
    double a = high - golden * (high - low), b = low + golden * (high - low);
    double at_a = function(a), at_b = function(b);
    for (int step = 0; step < kSections; ++step) {
        if (at_a < at_b) {
            high = b;
            b = a;
            at_b = at_a;
            a = high - golden * (high - low);
            at_a = function(a);
        } else {
            low = a;
            a = b;
            at_a = at_b;
            b = low + golden * (high - low);
            at_b = function(b);
        }
    }
    return at_a < at_b ? a : b;
}

}  // namespace

Eigen::MatrixXd corner_correlation(const std::vector<Eigen::Vector2d>& on_board,
                                   const CornerNoise& noise) {
    const auto count = static_cast<Eigen::Index>(on_board.size());
    Eigen::MatrixXd result(count, count);
    for (Eigen::Index i = 0; i < count; ++i) {
        result(i, i) = 1;
        for (Eigen::Index j = 0; j < i; ++j) {
            const auto& a = on_board[static_cast<std::size_t>(i)];
            const auto& b = on_board[static_cast<std::size_t>(j)];
            result(i, j) = result(j, i) =
                noise.shared * std::exp(-(a - b).norm() / noise.reach_pitches);
        }
    }
    return result;
}

CornerNoise estimate_corner_noise(const std::vector<CornerRows>& views) {
    if (views.empty()) return {};
    const Likelihood white = likelihood(views, 0, 1);
    const CornerNoise independent{white.sigma};
    if (white.sigma <= 0) return independent;
    std::size_t share = 0, reach = 0;
    double least = white.minus_two_log;
    for (std::size_t r = 0; r < std::size(kReaches); ++r)
        for (std::size_t s = 1; s + 1 < std::size(kShares); ++s) {
            const double found = likelihood(views, kShares[s], kReaches[r]).minus_two_log;
            if (found >= least) continue;
            least = found;
            share = s;
            reach = r;
        }
    if (share == 0) return independent;
    CornerNoise noise{0, kShares[share], kReaches[reach], 0};
    const double factor = kReaches[1] / kReaches[0];
    const double near = std::log(noise.reach_pitches / factor), far = near + 2 * std::log(factor);
    for (int round = 0; round < 2; ++round) {
        noise.shared = least_between(kShares[share - 1], kShares[share + 1], [&](double s) {
            return likelihood(views, s, noise.reach_pitches).minus_two_log;
        });
        noise.reach_pitches = std::exp(least_between(near, far, [&](double log_reach) {
            return likelihood(views, noise.shared, std::exp(log_reach)).minus_two_log;
        }));
    }
    const Likelihood found = likelihood(views, noise.shared, noise.reach_pitches);
    noise.sigma_px = found.sigma;
    noise.evidence = white.minus_two_log - found.minus_two_log;
    return noise;
}

Eigen::MatrixXd shared_covariance(const std::vector<CornerRows>& views, const CornerNoise& noise) {
    const Eigen::Index parameters = views.front().by_shared.cols();
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(parameters, parameters);
    Eigen::MatrixXd scatter = information;
    for (const CornerRows& view : views) {
        const Eigen::MatrixXd pose =
            inverted(view.by_pose.transpose() * view.by_pose).inverse * view.by_pose.transpose();
        const Eigen::MatrixXd clear = view.by_shared - view.by_pose * (pose * view.by_shared);
        information += clear.transpose() * clear;
        const Eigen::MatrixXd c = corner_correlation(view.on_board, noise);
        const Eigen::Index half = c.rows();
        scatter += clear.topRows(half).transpose() * c * clear.topRows(half) +
                   clear.bottomRows(half).transpose() * c * clear.bottomRows(half);
    }
    const Eigen::MatrixXd inverse = inverted(information).inverse;
    const double variance = noise.sigma_px * noise.sigma_px;
    if (noise.shared == 0) return variance * inverse;
    // The inverse and what the correlation adds to it: a capped direction keeps its variance.
    return variance * (inverse + inverse * (scatter - information) * inverse);
}

}  // namespace stria

#include "calib/corner_noise.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <iostream>
#include <random>

namespace stria {
namespace {

constexpr int kColumns = 9, kRows = 6, kShared = 5;

/// Views whose own parameters shift and shear the corners, as a pose does to first order, and whose
/// shared ones bend them as a lens does; every second view lacks some corners.
std::vector<CornerRows> bent_views(int count, std::mt19937& rng) {
    std::normal_distribution<double> unit(0, 1);
    std::vector<CornerRows> views;
    for (int v = 0; v < count; ++v) {
        CornerRows view;
        for (int row = 0; row < kRows; ++row)
            for (int column = 0; column < kColumns; ++column)
                if (v % 2 == 0 || row + column > 2) view.on_board.emplace_back(column, row);
        const auto corners = static_cast<Eigen::Index>(view.on_board.size());
        view.by_pose = Eigen::MatrixXd::Zero(2 * corners, 6);
        view.by_shared.resize(2 * corners, kShared);
        const double shift_x = 0.3 * unit(rng), shift_y = 0.3 * unit(rng), tilt = unit(rng);
        for (Eigen::Index i = 0; i < corners; ++i) {
            const Eigen::Vector2d& p = view.on_board[static_cast<std::size_t>(i)];
            const double x = p.x() / 4 - 1 + shift_x, y = p.y() / 2.5 - 1 + shift_y;
            view.by_pose.row(i) << 1, x, y, 0, 0, 0;
            view.by_pose.row(corners + i) << 0, 0, 0, 1, x, y;
            const double r2 = x * x + y * y;
            view.by_shared.row(i) << x * r2, x * r2 * r2, 2 * x * y, r2 + 2 * x * x, tilt * x * y;
            view.by_shared.row(corners + i) << y * r2, y * r2 * r2, r2 + 2 * y * y, 2 * x * y,
                tilt * y * y;
        }
        view.residual = Eigen::VectorXd::Zero(2 * corners);
        views.push_back(std::move(view));
    }
    return views;
}

/// The noise model once more, by its formula.
Eigen::MatrixXd covariance_of(const CornerRows& view, const CornerNoise& noise) {
    const Eigen::Index rows = view.residual.size(), half = rows / 2;
    Eigen::MatrixXd c = Eigen::MatrixXd::Zero(rows, rows);
    for (Eigen::Index i = 0; i < half; ++i)
        for (Eigen::Index j = 0; j < half; ++j) {
            const double away = (view.on_board[static_cast<std::size_t>(i)] -
                                 view.on_board[static_cast<std::size_t>(j)])
                                    .norm();
            const double value = noise.sigma_px * noise.sigma_px *
                                 ((i == j ? 1 - noise.shared : 0.0) +
                                  noise.shared * std::exp(-away / noise.reach_pitches));
            c(i, j) = c(half + i, half + j) = value;
        }
    return c;
}

/// All views in one design matrix: the shared columns, then six of each view.
Eigen::MatrixXd design(const std::vector<CornerRows>& views) {
    Eigen::Index rows = 0;
    for (const CornerRows& view : views) rows += view.residual.size();
    Eigen::MatrixXd x =
        Eigen::MatrixXd::Zero(rows, kShared + 6 * static_cast<Eigen::Index>(views.size()));
    Eigen::Index row = 0, column = kShared;
    for (const CornerRows& view : views) {
        x.block(row, 0, view.residual.size(), kShared) = view.by_shared;
        x.block(row, column, view.residual.size(), 6) = view.by_pose;
        row += view.residual.size();
        column += 6;
    }
    return x;
}

/// Draws errors, fits, leaves the residuals in the views; returns the errors of the shared part.
Eigen::VectorXd draw_and_fit(std::vector<CornerRows>& views, const CornerNoise& noise,
                             std::mt19937& rng) {
    std::normal_distribution<double> unit(0, 1);
    const Eigen::MatrixXd x = design(views);
    Eigen::VectorXd errors(x.rows());
    Eigen::Index row = 0;
    for (const CornerRows& view : views) {
        const Eigen::LLT<Eigen::MatrixXd> factor(covariance_of(view, noise));
        Eigen::VectorXd white(view.residual.size());
        for (double& value : white) value = unit(rng);
        errors.segment(row, white.size()) = factor.matrixL() * white;
        row += white.size();
    }
    const Eigen::VectorXd step = (x.transpose() * x).ldlt().solve(x.transpose() * errors);
    const Eigen::VectorXd left = errors - x * step;
    row = 0;
    for (CornerRows& view : views) {
        view.residual = left.segment(row, view.residual.size());
        row += view.residual.size();
    }
    return step.head<kShared>();
}

TEST(CornerNoise, CovarianceIsTheSandwichOfTheWholeDesign) {
    std::mt19937 rng(1);
    const auto views = bent_views(5, rng);
    const Eigen::MatrixXd x = design(views);
    for (const CornerNoise noise : {CornerNoise{0.2}, CornerNoise{0.2, 0.6, 2.5}}) {
        Eigen::MatrixXd c = Eigen::MatrixXd::Zero(x.rows(), x.rows());
        Eigen::Index row = 0;
        for (const CornerRows& view : views) {
            c.block(row, row, view.residual.size(), view.residual.size()) =
                covariance_of(view, noise);
            row += view.residual.size();
        }
        const Eigen::MatrixXd inverse =
            (x.transpose() * x).ldlt().solve(Eigen::MatrixXd::Identity(x.cols(), x.cols()));
        const Eigen::MatrixXd expected =
            (inverse * x.transpose() * c * x * inverse).topLeftCorner<kShared, kShared>();
        const Eigen::MatrixXd found = shared_covariance(views, noise);
        EXPECT_LT((found - expected).norm(), 1e-9 * expected.norm()) << noise.shared;
    }
}

TEST(CornerNoise, OfIndependentErrorsLittleIsCalledShared) {
    std::mt19937 rng(2);
    auto views = bent_views(7, rng);
    int refuted = 0;
    double chi_square = 0;
    const int trials = 200;
    for (int trial = 0; trial < trials; ++trial) {
        const Eigen::VectorXd error = draw_and_fit(views, {0.3}, rng);
        const CornerNoise noise = estimate_corner_noise(views);
        chi_square += error.dot(shared_covariance(views, noise).ldlt().solve(error));
        refuted += noise.refutes_independence();
    }
    const double count = trials * kShared;
    std::cout << "chi-square " << chi_square / count << " a degree of freedom; " << refuted
              << " of " << trials << " called shared" << std::endl;
    EXPECT_LE(refuted, 6);  // at most 2 expected
    // What little is found by chance makes the covariance a little too large, never too small.
    EXPECT_LT(chi_square / count, 1 + 4 * std::sqrt(2 / count));
    EXPECT_GT(chi_square / count, 0.9 - 4 * std::sqrt(2 / count));
}

TEST(CornerNoise, OfSharedErrorsTheCovarianceHoldsAsADistribution) {
    std::mt19937 rng(3);
    auto views = bent_views(12, rng);
    const CornerNoise truth{0.3, 0.5, 2.0};
    const Eigen::VectorXd true_variance = shared_covariance(views, truth).diagonal();
    Eigen::VectorXd variance = Eigen::VectorXd::Zero(kShared);
    double chi_square = 0, as_if_white = 0;
    int refuted = 0;
    const int trials = 100;
    for (int trial = 0; trial < trials; ++trial) {
        const Eigen::VectorXd error = draw_and_fit(views, truth, rng);
        const CornerNoise noise = estimate_corner_noise(views);
        double squares = 0, degrees = -kShared;
        for (const CornerRows& view : views) {
            squares += view.residual.squaredNorm();
            degrees += static_cast<double>(view.residual.size()) - 6;
        }
        const CornerNoise white{std::sqrt(squares / degrees)};
        chi_square += error.dot(shared_covariance(views, noise).ldlt().solve(error));
        refuted += noise.refutes_independence();
        as_if_white += error.dot(shared_covariance(views, white).ldlt().solve(error));
        variance += shared_covariance(views, noise).diagonal() / trials;
    }
    const double count = trials * kShared;
    std::cout << "chi-square " << chi_square / count << " a degree of freedom, as if independent "
              << as_if_white / count << "; variances found / true "
              << variance.cwiseQuotient(true_variance).transpose() << std::endl;
    // 4 standard deviations of chi-square's mean, and 0.1 because the noise is itself estimated:
    // enough to see what errors taken as independent would claim.
    const double tolerance = 4 * std::sqrt(2 / count) + 0.1;
    EXPECT_NEAR(chi_square / count, 1, tolerance);
    EXPECT_GT(as_if_white / count, 1 + tolerance);
    EXPECT_EQ(refuted, trials);
    // Share and reach trade with each other once poses are fitted; what they mean must hold.
    for (Eigen::Index i = 0; i < kShared; ++i)
        EXPECT_NEAR(variance[i] / true_variance[i], 1, 0.15) << i;
}

TEST(CornerNoise, WithoutRowsToSpareNothingIsClaimed) {
    std::mt19937 rng(4);
    auto views = bent_views(1, rng);
    CornerRows& view = views.front();
    view.on_board.resize(5);
    view.residual = Eigen::VectorXd::Zero(10);
    view.by_pose = Eigen::MatrixXd(view.by_pose.topRows(10));
    view.by_shared = Eigen::MatrixXd(view.by_shared.topRows(10));
    const CornerNoise noise = estimate_corner_noise(views);
    EXPECT_EQ(noise.sigma_px, 0);
    EXPECT_EQ(noise.shared, 0);
    EXPECT_EQ(estimate_corner_noise({}).sigma_px, 0);
}

}  // namespace
}  // namespace stria

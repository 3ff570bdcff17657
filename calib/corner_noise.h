#pragma once
#include <Eigen/Core>
#include <vector>

namespace stria {

/// The used corners of one view, linearised about a solution. Rows: x of all corners, then y.
struct CornerRows {
    std::vector<Eigen::Vector2d> on_board;  ///< of each corner, in pitches of the board
    Eigen::VectorXd residual;               ///< times the corner's weight, px
    Eigen::MatrixXd by_shared;              ///< for what the views have in common
    Eigen::MatrixXd by_pose;                ///< for the board's pose, 6 columns
};

/// How corners err: sigma^2 ((1 - shared) I + shared exp(-distance on the board / reach)) within a
/// view, x and y alike and independent, views independent.
struct CornerNoise {
    double sigma_px = 0;       ///< standard deviation of one coordinate
    double shared = 0;         ///< share of the variance that neighbours have in common, [0, 1)
    double reach_pitches = 1;  ///< at that distance the correlation has fallen to 1/e
    /// Twice the log of the likelihood ratio against independent errors: above 9.21 these are
    /// refuted at the 1 % level.
    double evidence = 0;
    bool refutes_independence() const { return evidence > 9.21; }
};

/// The noise that makes the residuals most likely, poses and shared parameters free: restricted
/// maximum likelihood, which knows what the fit has taken from the residuals (Patterson and
/// Thompson 1971). All 0 where there are no more rows than parameters.
CornerNoise estimate_corner_noise(const std::vector<CornerRows>& views);

/// Correlation matrix of corners at these places on the board (pitches) that err like that.
Eigen::MatrixXd corner_correlation(const std::vector<Eigen::Vector2d>& on_board,
                                   const CornerNoise& noise);

/// Covariance of the shared parameters of a plain least-squares fit, poses free, of corners that
/// err like that: H^-1 (sum J' C J) H^-1 with J clear of the pose (the sandwich; White 1980, for
/// correlated places Conley 1999). Directions weaker than 1e-14 of the unit-diagonal information
/// are capped there: it stays finite.
Eigen::MatrixXd shared_covariance(const std::vector<CornerRows>& views, const CornerNoise& noise);

}  // namespace stria

#pragma once
#include <ceres/problem.h>

#include <vector>

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

struct SolveEnd {
    double initial_cost = 0, final_cost = 0;  ///< half the chi-square
    int iterations = 0;
    bool converged = false;
};

/// Least squares in narrow curved valleys, where a straight step leaves the floor at once and a
/// solver that damps its steps creeps.
///
/// Each iteration takes Gauss and Newton's step, with the true second derivatives of the cost along
/// the few directions that the residuals see least (from second differences of the residuals):
/// there what the residuals' curvature adds may be ten times J'J, or below zero. The way is the
/// parabola x + t v + t^2 a / 2 with the geodesic acceleration a of Transtrum and Sethna
/// ("Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares minimization",
/// arXiv:1201.5885, section 2), t halved until the cost falls, each trial taken back to the floor
/// by one step in the other directions.
///
/// Every residual touches shared blocks and at most one separate one. Held blocks stay; loss
/// functions and bounds are not looked at. Converged: the step promises less than 0.001 of half the
/// chi-square, 0.05 standard deviations.
SolveEnd valley_solve(ceres::Problem& problem, const std::vector<double*>& shared,
                      const std::vector<double*>& separate, int max_iterations);

}  // namespace stria

#pragma once
#include <vector>

#include "host/registration/joint.h"
#include "host/registration/matches.h"

namespace stria {

/// Matches of one scan's samples on another, with what becomes of them in a step. Used inside
/// host/registration only.
struct PairMatches {
    std::size_t source = 0, target = 0;  ///< scans
    double gate_mm = 0;                  ///< distance gate of the next association
    std::vector<std::uint32_t> warm;
    std::vector<Match> matches;
    std::vector<double> residual_mm;  ///< one a match
    std::vector<double> distance_mm;  ///< one a match
    std::vector<double> sigma_mm;     ///< one a match; 1 mm where unknown
    std::vector<double> weight;       ///< robust weight / sigma^2 / spread^2
    double spread = 1;                ///< robust standard deviation of residual / sigma
};

/// The joint least-squares problem in the unknowns of one step: for every scan a rotation (times
/// `scale_mm`, so all unknowns are mm) about `centre` and a translation, world frame.
struct JointProblem {
    const SurfaceList& surfaces;
    const std::vector<Rigid3>& poses;  ///< world_from_scan
    std::vector<int> block;            ///< first unknown of each scan; -1: fixed
    int unknowns = 0;
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double scale_mm = 1;

    /// Row of the derivative of a match's residual by the step of its source scan; that by the
    /// step of its target scan is the negative.
    Vector6d row(const PairMatches& pair, const Match& match) const;
    /// From `centre` to the match's source point, world frame, mm.
    Eigen::Vector3d arm(const PairMatches& pair, const Match& match) const;
};

/// Normal matrix and gradient of the weighted matches, and the information that the scatter of the
/// normals alone would feign: a direction is determined only if it has plainly more than that.
struct NormalEquations {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd gradient;
    Eigen::MatrixXd feigned;
};
NormalEquations build_equations(const JointProblem& problem, const std::vector<PairMatches>& pairs);

/// Step that minimises; directions with no more than the feigned information are left alone.
Eigen::VectorXd solve_step(const NormalEquations& equations);

/// World motion of a scan whose unknowns are `step`.
Rigid3 motion_of_step(const JointProblem& problem, const Vector6d& step);

/// Fills covariance, sigmas, open directions of every scan.
void fill_covariance(const JointProblem& problem, const std::vector<PairMatches>& pairs,
                     std::vector<JointScan>& scans);

}  // namespace stria

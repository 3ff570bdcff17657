#pragma once
#include <string>
#include <vector>

#include "host/core/range_image.h"
#include "host/core/rigid3.h"
#include "host/core/scan_pose.h"
#include "host/registration/scan_surface.h"

namespace stria {

struct JointOptions {
    /// Matches farther apart are not believed in the first step; later steps narrow it pair by
    /// pair. 0: a tenth of the median scan's extent, which suits poses a few degrees off.
    double start_distance_mm = 0;
    double max_normal_angle_rad = 0.7854;  ///< 45 deg, the bound of the overlap figure
    int samples_per_scan = 30000;          ///< at full resolution; more gain little
    int max_iterations = 80;               ///< of all levels together
    double tolerance_mm = 0;  ///< converged when no point moves farther in a step; 0: pitch / 500
    int min_matches = 50;     ///< a pair with fewer has no say
};
/// Empty if usable, else field, value and bound.
std::string validate(const JointOptions& options);

/// One outer step, for the report's convergence plot.
struct JointStep {
    int level = 0;               ///< 0: coarsest sampling
    double rms_mm = 0;           ///< of the weighted point-to-plane distances, before the step
    double largest_move_mm = 0;  ///< of any scan's points
    std::size_t matches = 0;
};

struct JointScan {
    Rigid3 world_from_scan;
    Matrix6d covariance = Matrix6d::Zero();  ///< order rx ry rz tx ty tz; zero if fixed
    double sigma_rad = 0;     ///< root of the trace of the rotation's covariance; infinite: open
    double sigma_mm = 0;      ///< the same of the displacement of the scan's centre
    std::size_t matches = 0;  ///< with all other scans, in the last step
    int open_directions = 0;  ///< of its 6, not determined by the matches
    bool fixed = false;
};

struct JointResult {
    bool converged = false;     ///< steps became small, every scan is matched, no direction is open
    std::string reason;         ///< why not; empty if converged
    double overlap_rms_mm = 0;  ///< see overlap_rms_mm in matches.h
    std::vector<JointScan> scans;
    int iterations = 0;
    std::vector<JointStep> history;
};

/// Poses of all scans that make their overlaps agree best, all at once: point-to-plane distances of
/// every overlapping pair, both ways, matched anew in every outer step, one Cholesky solution over
/// the 6N unknowns, Tukey weights whose width follows each pair's own spread (graduated from coarse
/// to fine), weights from sigma where both scans know theirs. The scans marked fixed stay where
/// they are, the first one if none is. Directions that the matches leave open (a plane slides on a
/// plane) are not moved along and are counted.
///
/// The covariance carries the points' random sigma through the solution, each point's noise taken
/// once however many matches share it; without sigmas the spread of the residuals stands for it.
///
/// Deterministic for any thread count. Scans without surface are allowed and reported as unmatched.
/// Sources: Chen and Medioni 1992 (point to plane); Turk and Levoy 1994 (border matches rejected);
/// Pulli 1999 and Neugebauer 1997 (all scans jointly).
/// @param initial  world_from_scan, one a surface; `fixed` is heeded
JointResult register_jointly(const SurfaceList& surfaces, const std::vector<ScanPose>& initial,
                             const JointOptions& options = {});
JointResult register_jointly(const std::vector<ScanSurface>& surfaces,
                             const std::vector<ScanPose>& initial,
                             const JointOptions& options = {});

}  // namespace stria

#pragma once
#include <limits>

#include "calib/scanner_problem.h"

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

struct OtherMirror {
    bool taken = false;  ///< the problem now stands at the other solution
    /// Half the chi-square by which the worse of the two is worse; infinite where there is one.
    double margin = std::numeric_limits<double>::infinity();
};

/// Looks for a second solution of a swept machine's problem, and takes it if it is the better one.
///
/// Over a short sweep the path of the reflected sheet's normal tells three numbers (where it is
/// along the mirror's axis, its slope and its curvature) of four: the tilts against the axis of the
/// incoming sheet and of the mirror, and the two of the axis. The fourth shows only in second
/// order, as the root of a quadratic, and its other root may hold a false minimum. So m0 is tilted
/// by +-tilt_rad towards the axis, the rest follows, and what ends elsewhere with a lower cost is
/// kept.
/// @param problem  converged with the parameters of stage `all` free; its weights are kept
OtherMirror take_better_mirror(ScannerProblem& problem, const ScannerProblem::Stage& all,
                               double tilt_rad);

}  // namespace stria

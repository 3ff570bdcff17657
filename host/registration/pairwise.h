#pragma once
#include <string>

#include "host/core/rigid3.h"
#include "host/registration/joint.h"
#include "host/registration/scan_surface.h"

namespace stria {

struct PairResult {
    bool converged = false;  ///< steps became small and no direction is open
    std::string reason;      ///< why not; empty if converged
    Rigid3 target_from_source;
    Matrix6d covariance = Matrix6d::Zero();  ///< order rx ry rz tx ty tz
    int open_directions = 0;                 ///< of 6, not determined by the overlap
    double overlap_rms_mm = 0;
    std::size_t matches = 0;
    int iterations = 0;
};

/// Pose of one scan on another by iterated closest points, point to plane, both ways, so that the
/// exchange of the two gives the inverse: register_jointly with two scans, of which `target` stays.
/// Borders, normals, distance gate and Tukey weights as there.
/// @param initial  target_from_source to start from, some degrees and millimetres off at most
PairResult register_pair(const ScanSurface& source, const ScanSurface& target,
                         const Rigid3& initial, const JointOptions& options = {});

}  // namespace stria

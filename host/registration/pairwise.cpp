#include "host/registration/pairwise.h"

namespace stria {

PairResult register_pair(const ScanSurface& source, const ScanSurface& target,
                         const Rigid3& initial, const JointOptions& options) {
    ScanPose stays, moves;
    stays.file = "target";
    stays.fixed = true;
    moves.file = "source";
    moves.world_from_scan = initial;
    const JointResult joint =
        register_jointly(SurfaceList{&target, &source}, {stays, moves}, options);
    const JointScan& scan = joint.scans[1];
    PairResult result;
    result.converged = joint.converged;
    result.reason = joint.reason;
    result.target_from_source = scan.world_from_scan;
    result.covariance = scan.covariance;
    result.open_directions = scan.open_directions;
    result.overlap_rms_mm = joint.overlap_rms_mm;
    result.matches = scan.matches;
    result.iterations = joint.iterations;
    return result;
}

}  // namespace stria

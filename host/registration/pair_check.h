#pragma once
#include "host/core/rigid3.h"
#include "host/registration/line_of_sight.h"
#include "host/registration/scan_surface.h"

namespace stria {

/// How two scans take to each other in a given pose.
struct PairCheck {
    double overlap = 0;  ///< share of the smaller scan's points that lie on the other's surface
    double contradiction = 0;  ///< share of the smaller scan's points, of both together, that lie
                               ///< where the other scan saw empty space
    double missing = 0;        ///< share of the smaller scan's points, of both together, that face
                               ///< the other's camera and laser but were not seen by it
    double rms_mm = 0;         ///< point-to-plane over the points that agree
    double looseness = 0;      ///< rms_mm over what points strewn evenly over the tolerance have:
                               ///< near 0 for one surface, near 1 for two that merely cross
    double agreeing = 0;       ///< number of points that agree, mean of both
};

/// A thinned scan with what it saw.
struct CheckedScan {
    ScanSurface thin;
    LineOfSight sight;
    LineOfSight light;  ///< from the laser: what lies in shadow
};

struct PairTolerance {
    double surface_mm = 1;   ///< a point agrees within this of the other surface, along its normal
    double free_mm = 3;      ///< and contradicts this far in front of what the other saw
    std::size_t stride = 1;  ///< every so manieth point is looked at
};

/// Counts, both ways: points that agree with the other surface (distance, and normals within 30
/// degrees), and points that do not and lie in front of what the other saw.
PairCheck check_pair(const CheckedScan& source, const CheckedScan& target,
                     const Rigid3& target_from_source, const PairTolerance& tolerance);

}  // namespace stria

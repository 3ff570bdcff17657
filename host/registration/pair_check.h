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
    double rms_mm = 0;         ///< point-to-plane over the points that agree
    double agreeing = 0;       ///< number of points that agree, mean of both
};

/// A thinned scan with what it saw.
struct CheckedScan {
    ScanSurface thin;
    LineOfSight sight;
};

/// Counts, both ways: points that agree with the other surface within half the spacing and 30
/// degrees, and points that do not and lie more than `free_mm` in front of what the other saw.
/// @param detail_mm  spacing of the thinned points
PairCheck check_pair(const CheckedScan& source, const CheckedScan& target,
                     const Rigid3& target_from_source, double detail_mm, double free_mm);

}  // namespace stria

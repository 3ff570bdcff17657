#pragma once
#include <string>
#include <vector>

#include "host/core/rigid3.h"
#include "host/registration/scan_surface.h"

namespace stria {

struct CoarseOptions {
    double detail_mm = 0;       ///< spacing of the points that are compared; 0: a 130th of the
                                ///< median scan's extent, but at least twice the pitch
    int max_hypotheses = 6;     ///< poses kept for each pair of scans until verified
    double min_overlap = 0.12;  ///< share of the smaller scan's points that must agree
    double max_contradiction = 0.015;  ///< share of points that may lie in space seen empty:
                                       ///< edges and mixed points do
    double max_looseness = 0.7;  ///< see PairCheck: false poses have 0.75 to 1, true ones 0.1 to
                                 ///< 0.2 and as much as noise of a third of the detail adds
    double max_missing = 0.08;   ///< share of points that the other scan should have seen and did
                                 ///< not; dark and shiny parts leave some out
};
/// Empty if usable, else field, value and bound.
std::string validate(const CoarseOptions& options);

/// A pose of one scan on another that the two scans themselves do not contradict.
struct CoarsePair {
    std::size_t source = 0, target = 0;
    Rigid3 target_from_source;
    double overlap = 0;        ///< share of the smaller scan's points that agree
    double contradiction = 0;  ///< share of points of either in space the other saw empty
    double missing = 0;        ///< share of points the other should have seen and did not
    double rms_mm = 0;         ///< point-to-plane, of the points that agree
    double score = 0;          ///< area that agrees, less for contradictions and looseness
    bool used = false;         ///< joined two groups of scans
};

struct CoarseScan {
    bool placed = false;
    std::string reason;      ///< why not
    Rigid3 world_from_scan;  ///< world: the scan frame of the first placed scan
};

struct CoarseResult {
    bool all_placed = false;
    double detail_mm = 0;  ///< spacing compared; the poses are good to about that, so twice
                           ///< it suits JointOptions::start_distance_mm
    std::vector<CoarseScan> scans;
    std::vector<CoarsePair> pairs;  ///< all that passed the verification, best first
};

/// Poses of scans of one part from unknown directions, by their shape alone, good enough to start
/// register_jointly from. Every pair of scans is compared by local shape (fast point feature
/// histograms); sets of correspondences that agree with each other in their distances give poses,
/// refined and verified by how much surface agrees and by free space: a point of one scan in front
/// of what the other saw contradicts the pose. Pairs join groups of scans best first, and only if
/// the joint group contradicts itself nowhere; a scan that no pair joins to the largest group is
/// said not to be placed, never guessed.
///
/// No random numbers: deterministic for any thread count. Cost grows with the pairs of scans.
/// Sources: Rusu, Blodow and Beetz 2009 (FPFH); Chen et al. 2022 (second-order spatial
/// compatibility); Huber and Hebert 2003 (joining pairs with global checks).
CoarseResult place_scans(const std::vector<ScanSurface>& surfaces,
                         const CoarseOptions& options = {});

}  // namespace stria

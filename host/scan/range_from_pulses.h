#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "firmware/core/pulse.h"
#include "host/core/range_image.h"
#include "host/core/scanner_model.h"
#include "host/scan/centre_of_light.h"
#include "host/scan/compare_directions.h"

namespace stria {

struct RangeOptions {
    /// Standard deviation of the axis position (mm or rad) that the log states; adds to each
    /// point's random sigma.
    double axis_sigma_s = 0;
    /// A pulse whose width differs from what the beam can be by more than these factors is mixed
    /// from two surfaces or a ghost: rejected. Measured against the scan's own median ratio, since
    /// the stated waist is a design value. accuracy.md A.1, multi-peak handling.
    double min_width_ratio = 0.7;
    double max_width_ratio = 1.4;
    /// Points outside the model's valid volume are rejected where the model states one.
    bool keep_outside_volume = false;
    /// Swept spacetime: standard deviation of what a pixel sees, px, by which points are moved to
    /// the middle of the light that timed them (centre_of_light.h); 0: they stay on their pixel's
    /// ray. Not set: as the pulses themselves show it; if they do not, those of partly lit pixels
    /// alone are moved.
    std::optional<double> footprint_px = std::nullopt;
    /// Swept spacetime: the pulses' kPulseGhostSuspected came from two directions of the axis
    /// (compare_directions.h), not from strength alone: it stays.
    bool directions_compared = false;
    /// Leading calibration errors kept for each point.
    int sensitivity_count = 4;
};

/// What became of the pulses.
struct RangeStatistics {
    std::size_t pulses = 0;
    std::size_t no_intersection = 0;  ///< the ray misses or grazes the sheet
    std::size_t outside_volume = 0;
    std::size_t wrong_width = 0;
    std::size_t cells_with_choice = 0;  ///< cells where more than one pulse was possible
    std::size_t turned_away = 0;        ///< swept spacetime: pulses flagged as ghosts
    std::size_t ambiguous = 0;          ///< swept spacetime: cells flagged, the choice open
    std::size_t near_merging = 0;       ///< swept spacetime: cells flagged beside merging pulses
    std::size_t contradicted = 0;       ///< points that the other direction of the axis denies
    std::size_t points = 0;             ///< cells with a point
    PixelFootprint footprint;           ///< that points were moved by; 0: not known
    std::size_t partly_lit = 0;         ///< points moved into the lit part of their pixel
    double median_sigma_mm = 0;
    double median_systematic_mm = 0;
    std::optional<DirectionComparison> directions;  ///< of the pulses, by who merged the passes
};

struct RangeResult {
    RangeImage image;
    RangeStatistics statistics;
    std::vector<std::string> notes;  ///< for people: what was noticed on the way
};

/// Range image of a sweep: every pulse's ray meets the sheet at its s (DESIGN, "One model for every
/// scanner"). The pulses' s and ds_dt must be assigned. Swept spacetime: ghosts are
/// flagged and the point of a cell is chosen as judge_pulses.h says. Else the pulse without
/// warnings, then the strongest, becomes the point. The others become further returns.
/// sigma_mm is the pulse's own sigma carried through the geometry: along the camera ray for
/// spacetime pulses, inside the sheet for spatial peaks. Points of swept spacetime are moved inside
/// the sheet to their centre of light. sigma_systematic_mm is the model's
/// covariance carried through, the rigid motion common to all points removed.
/// Throws stria::Error if the model has no channel for the map's camera and laser.
RangeResult range_from_pulses(const PulseMap& pulses, const ScannerModel& model,
                              const RangeOptions& options = {});

}  // namespace stria

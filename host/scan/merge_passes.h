#pragma once
#include <span>
#include <string>

#include "firmware/core/pulse.h"

namespace stria {

/// What the cells of a sweep's maps are.
enum class PassGrid {
    image,   ///< pixels: swept spacetime
    frames,  ///< frame k, image row v: spatial peaks, and spacetime along paths
};

/// The passes of a sweep (exposures, directions, lasers) as one map, at most kMaxPulsesPerCell in a
/// cell, the strongest, after what is suspected as a ghost gave way. On the image's grid, pulses of
/// one pixel and laser that differ by less than kSamePlace (compare_directions.h) of their standard
/// deviations along the axis are one pulse, seen several times: its position is their mean weighted
/// by 1 / sigma^2, which is the maximum of their joint likelihood (a clipped pulse weighs little,
/// because clipping raised its sigma), its sigma that of the mean, all else of the most precise
/// one, and suspected as a ghost if any of them is. What differs stays apart. On a grid of frames
/// the passes' frames have positions of their own: cells are joined, a pass back read from its end
/// so that neighbours stay neighbours, and passes may differ by some frames. Needs s and ds_dt.
/// Throws stria::Error naming `name` where grids or modes differ otherwise.
/// @param axis_sigma_s  standard deviation of each s besides the pulses' own, to compare them with;
///                      the merged sigma is the pulses' alone
PulseMap merge_passes(std::span<const PulseMap> passes, PassGrid grid, const std::string& name,
                      double axis_sigma_s = 0);

}  // namespace stria

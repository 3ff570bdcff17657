#pragma once
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/core/pulse.h"
#include "host/core/image.h"

namespace stria {

/// The frame in grey, three times its size and brightened until its brightest part is light grey,
/// with every peak as a small cross in green (flagged ones in orange) at its sub-pixel place.
/// @param transposed  the frame was transposed for the analysis; the picture is upright again
ColourImage picture_of_peaks(const Frame& frame, const std::vector<Pulse>& peaks,
                             bool transposed = false);

/// The strongest pulse of every cell, coloured by its time; cells without one are white.
ColourImage picture_of_pulses(const PulseMap& map, int max_side = 1024);

}  // namespace stria

#pragma once
#include "firmware/core/frame.h"

namespace stria {

/// Light between pixels.
struct InterpolatedSample {
    double value = 0;           ///< DN
    double variance_share = 1;  ///< sum of the squared weights: variance over that of one pixel
    bool saturated = false;     ///< all pixels that it rests on are at full scale: truly more
    bool spoiled = false;       ///< some are: the value means nothing
};

/// True if interpolated_sample may be asked for (u, v).
inline bool can_interpolate(const Frame& frame, double u, double v) {
    return u >= 1 && v >= 1 && u < frame.width - 2 && v < frame.height - 2;
}

/// Cubic convolution over 4 x 4 pixels (Keys 1981, a = -1/2).
InterpolatedSample interpolated_sample(const Frame& frame, double u, double v);

}  // namespace stria

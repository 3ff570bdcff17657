#pragma once
#include <span>
#include <vector>

#include "firmware/core/frame.h"

namespace stria::test_support {

/// Where the beam's centre crossed a surface point, in the recorded images.
struct SpacetimeMean {
    double u = 0, v = 0;   ///< column, row
    double frame = 0;      ///< fractional
    double amplitude = 0;  ///< DN
};

/// One angle for the whole field.
struct RotationOptions {
    double slope_px = 0;      ///< columns by which a surface point moves from frame to frame
    double width_frames = 0;  ///< of a pulse, standard deviation
    double least_dn = 0;      ///< a lower pulse is none
};

/// The rotated spacetime image of Curless and Levoy 1995, section 4, as they describe it: the image
/// of one scan line over the frames is turned until the pulses stand upright, the statistics (mean)
/// of every column are taken, and the means are turned back. theta_ST = atan((dz/dx) tan theta),
/// which in pixels is the angle whose tangent is 1 / slope_px from the frames' axis. Light between
/// samples by cubic convolution, means over three widths to each side of themselves.
std::vector<SpacetimeMean> rotated_spacetime_means(std::span<const Frame> frames, int row,
                                                   const RotationOptions& options);

}  // namespace stria::test_support

#pragma once
#include <vector>

#include "firmware/core/pulse.h"
#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/frame_store.h"
#include "firmware/stripe/spacetime.h"

namespace stria {

/// Frames [begin, end) of one pixel in which its light rose and fell.
struct PixelWindow {
    int x = 0, y = 0;
    int begin = 0, end = 0;
    float background = 0;          ///< DN, as tracked before the rise
    bool at_sequence_end = false;  ///< end is the end of the sweep
};

/// Effective number of samples of the pulse: (sum a)^2 / sum a^2 over the samples more than two
/// standard deviations above the background; 0 if its peak is below `min_peak` DN. 1 for a pulse
/// one sample wide, 3.5 x width / frame period for a well sampled Gaussian.
double effective_samples(const FrameStore& frames, const PixelWindow& window,
                         const SensorNoise& noise, double min_peak);

/// Fits the window in time and appends its one or two pulses, if there are any.
void fit_window(const FrameStore& frames, const PixelWindow& window, const SensorNoise& noise,
                const SpacetimeOptions& options, std::vector<Pulse>& pulses);

}  // namespace stria

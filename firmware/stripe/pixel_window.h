#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "firmware/core/pulse.h"
#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/frame_store.h"
#include "firmware/stripe/spacetime.h"

namespace stria {

constexpr double kMinPulseWidth = 0.4;  ///< frame periods; a narrower pulse is undersampled

/// Frames [begin, end) of one pixel in which its light rose and fell.
struct PixelWindow {
    int x = 0, y = 0;
    int begin = 0, end = 0;
    float background = 0;          ///< DN, as tracked before the rise
    float level = 0;               ///< DN, the least that counted as light
    bool at_sequence_end = false;  ///< end is the end of the sweep
};

/// What counts as a pulse over a background, DN above it.
struct PulseLevels {
    float least;     ///< of a sample of a pulse: two standard deviations of the background
    float smallest;  ///< height of a pulse
    /// The greatest two successive samples together. A pulse of the smallest height and of 0.4
    /// frame periods shows 1.09 of it in these, any other more; a single outlier seldom does.
    float pair;
};
PulseLevels pulse_levels(const SensorNoise& noise, const SpacetimeOptions& options,
                         float background);

/// How many pulses had how many effective samples: bins of 0.05 from 1 on, the last open.
using SampleHistogram = std::array<std::uint32_t, 128>;

/// Effective number of samples of the pulse: (sum a)^2 / sum a^2 over the samples more than two
/// standard deviations above the background; 0 if its peak stands less than twice as far above the
/// background as `level`. 1 for a pulse one sample wide, 3.5 x width / frame period for a well
/// sampled Gaussian. Single precision, in the order of the frames.
float effective_samples(const FrameStore& frames, const PixelWindow& window,
                        const PulseLevels& levels);
/// Counts `samples`, unless 0.
void note_effective_samples(float samples, SampleHistogram& histogram);
/// Fits the window in time, unless its samples are below pulse_levels().pair, and appends its one
/// or two pulses, if there are any.
void fit_window(const FrameStore& frames, const PixelWindow& window, const SensorNoise& noise,
                const SpacetimeOptions& options, std::vector<Pulse>& pulses);

}  // namespace stria

#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "firmware/core/frame.h"
#include "firmware/core/pulse.h"
#include "firmware/core/sensor_noise.h"

namespace stria {

class SpacetimeEngine;

/// What counts as a pulse of the stripe over one pixel.
struct SpacetimeOptions {
    double min_snr = 6.0;         ///< height in the samples over the noise of the background
    double min_amplitude_dn = 3;  ///< DN; keeps quantisation steps of dark images out
    int max_pulses_per_cell = 2;  ///< 1..kMaxPulsesPerCell; the strongest are kept
    int max_pulse_frames = 96;    ///< a longer rise is a change of the light, not a pulse
    int history_frames = 16;      ///< kept before a rise, for its flank and background
    double max_misfit = 0.2;      ///< rms residual over amplitude above which it is no pulse
    double width_ratio = 2.0;     ///< widths beyond median x or / this are flagged
    int threads = 1;              ///< bands of rows; the result does not depend on it
    int sequence_step = 1;        ///< its frames are every so-manieth of the camera
    bool fast = false;            ///< frames of 8 bits by the SIMD kernels of fast_spacetime.h

    /// Throws std::invalid_argument naming field, value and bound.
    void validate() const;
};

/// How densely a sweep sampled the stripe: what the message about an undersampled one says.
struct SweepSampling {
    double samples_per_pulse = 0;  ///< median effective number, (sum a)^2 / sum a^2; 0: no pulses
    double step_px = 0;            ///< median way of the stripe between frames; 0: unknown
    double width_px = 0;           ///< median width of the stripe in the image; 0: unknown
};

/// Windows in which light rose and fell, and how many of them the reference's fit judged: all of
/// them without `fast`, few with it.
struct WindowCounts {
    std::uint64_t all = 0;
    std::uint64_t by_reference = 0;
};

/// Follows every pixel through the frames of a sweep and fits the pulses of the passing stripe in
/// time: maximum likelihood for an exposure-integrated Gaussian over a constant background, from
/// the rows' true times. The grid is the image; width and sigma are ns, t_ns device time; u, v the
/// pixel; s and ds_dt 0 (assign_axis_positions writes them). Two overlapping pulses are fitted
/// together where the Bayesian information criterion asks for it. Frames are kept only while a
/// pulse needs them, at most max_pulse_frames + history_frames and a batch of 8.
/// A sweep whose step exceeds the stripe's width gives an empty map with `undersampled` set.
class SpacetimeAnalyser {
  public:
    /// One analyser for each laser and each exposure index of a sweep.
    SpacetimeAnalyser(int width, int height, int bits, const SensorNoise& noise,
                      const SpacetimeOptions& options = {});
    ~SpacetimeAnalyser();
    SpacetimeAnalyser(SpacetimeAnalyser&&) noexcept;
    SpacetimeAnalyser& operator=(SpacetimeAnalyser&&) noexcept;

    /// Laser-on frames in time order. A frame that repeats a sequence number or is not later than
    /// the last one is ignored and counted. Throws std::invalid_argument on another size or depth.
    void add(const Frame& frame);
    /// The same without a copy: takes the frame over, unless it is ignored.
    void add(Frame&& frame);
    /// A frame that is needed no more, if there is one: its memory can hold another.
    std::optional<Frame> take_spare();
    /// The map of all frames so far. Call once, at the end.
    PulseMap finish();
    /// Valid after finish().
    const SweepSampling& sampling() const;
    int frames_ignored() const;
    WindowCounts windows() const;
    /// The most frames that were needed at any time.
    int most_frames() const;

  private:
    std::unique_ptr<SpacetimeEngine> engine_;
};

}  // namespace stria

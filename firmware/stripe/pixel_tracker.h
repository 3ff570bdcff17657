#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "firmware/stripe/detection_levels.h"
#include "firmware/stripe/frame_store.h"
#include "firmware/stripe/pixel_window.h"

namespace stria {

/// Follows the pixels of one row through the frames: knows each pixel's background, opens a window
/// where a sample exceeds it and hands the window on when the light has fallen again. The quiet
/// pixels, nearly all, cost one vectorised comparison a frame.
template <typename T>
class PixelTracker {
  public:
    PixelTracker(int width, int y, int full_scale, const SensorNoise& noise,
                 const SpacetimeOptions& options);

    /// Frames [begin, end) of the store, which holds all frames from oldest_needed() on. The first
    /// call sets the backgrounds from the least sample of each pixel.
    void advance(const FrameStore& frames, int begin, int end);
    /// Closes what is open: the sweep is over.
    void finish(const FrameStore& frames);
    /// First frame that a window now open may want; `otherwise` if none is open.
    int oldest_needed(int otherwise) const;

    std::vector<Pulse> pulses;
    SampleHistogram effective{};
    std::uint32_t saturated_samples = 0;
    std::uint64_t windows = 0;  ///< closed so far

  private:
    struct Open {
        int x;
        int first_above, last_above;
        int lead() const {
            return (last_above - first_above) / 2 + 4;
        }  // to four widths either side
    };

    void set_backgrounds(const FrameStore& frames, int begin, int end);
    void find_above(const T* row);
    void follow(const FrameStore& frames, int k);
    void close(const FrameStore& frames, const Open& open, int end, bool at_sequence_end);
    void update_backgrounds(const FrameStore& frames, int begin, int end);
    void set_thresholds();

    int width_, y_, full_scale_;
    SensorNoise noise_;
    SpacetimeOptions options_;
    DetectionLevels levels_;
    std::vector<std::uint32_t> background_;  ///< 1/256 DN
    std::vector<T> threshold_;
    std::vector<Open> open_, still_open_;  ///< ascending in x
    std::vector<int> above_;               ///< pixels of the present frame above their threshold
    bool started_ = false;
};

}  // namespace stria

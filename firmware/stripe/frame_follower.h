#pragma once
#include <cstdint>
#include <optional>

#include "firmware/core/frame.h"

namespace stria {

/// Watches the sequence numbers and times of a sweep's frames.
class FrameFollower {
  public:
    /// False for a frame that repeats a number, or is not later than the last accepted one: such
    /// frames are counted and must be left out. A gap in the numbers counts as dropped frames.
    /// @param step  from one of these frames' numbers to the next: lasers or exposures that take
    ///              turns
    bool accept(const Frame& frame, int step) {
        if (last_sequence_) {
            const std::uint32_t ahead = frame.sequence - *last_sequence_;  // wraps as the counter
            if (ahead == 0 || ahead > 0x7fffffffu || frame.exposure_start_ns <= last_time_ns_) {
                ++ignored_;
                return false;
            }
            dropped_ += (ahead - 1) / static_cast<std::uint32_t>(step);
        }
        last_sequence_ = frame.sequence;
        last_time_ns_ = frame.exposure_start_ns;
        return true;
    }
    std::uint32_t dropped() const { return dropped_; }
    int ignored() const { return ignored_; }

  private:
    std::optional<std::uint32_t> last_sequence_;
    TimeNs last_time_ns_ = 0;
    std::uint32_t dropped_ = 0;
    int ignored_ = 0;
};

}  // namespace stria

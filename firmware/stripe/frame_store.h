#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/core/frame.h"

namespace stria {

/// The latest frames of a sweep, numbered from 0 in the order they came; old ones are given back
/// and their memory is used again.
class FrameStore {
  public:
    /// Copies the frame; its number is count() - 1 afterwards.
    void add(const Frame& frame) {
        if (spare_.empty()) {
            frames_.push_back(frame);
        } else {
            frames_.push_back(std::move(spare_.back()));
            spare_.pop_back();
            frames_.back() = frame;
        }
    }
    /// Takes the frame over; its number is count() - 1 afterwards.
    void add(Frame&& frame) { frames_.push_back(std::move(frame)); }
    /// A frame that was given back, if there is one: its memory can hold another.
    std::optional<Frame> take_spare() {
        if (spare_.empty()) return std::nullopt;
        std::optional<Frame> frame = std::move(spare_.back());
        spare_.pop_back();
        return frame;
    }
    /// Gives back every frame before `number`.
    void release_before(int number) {
        while (first_ < number && !frames_.empty()) {
            spare_.push_back(std::move(frames_.front()));
            frames_.pop_front();
            ++first_;
        }
    }
    const Frame& at(int number) const { return frames_[static_cast<std::size_t>(number - first_)]; }
    int first() const { return first_; }
    int count() const { return first_ + static_cast<int>(frames_.size()); }
    /// Frames whose memory is held at present.
    std::size_t held() const { return frames_.size() + spare_.size(); }

  private:
    std::deque<Frame> frames_;
    std::vector<Frame> spare_;
    int first_ = 0;
};

/// A row of samples of a frame of that sample type.
template <typename T>
const T* row_of(const Frame& frame, int y);
template <>
inline const std::uint8_t* row_of(const Frame& frame, int y) {
    return frame.view8().row(y);
}
template <>
inline const std::uint16_t* row_of(const Frame& frame, int y) {
    return frame.view16().row(y);
}

}  // namespace stria

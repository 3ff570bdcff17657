#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "firmware/core/pulse.h"
#include "firmware/stripe/fast_kernels.h"
#include "firmware/stripe/large_pages.h"
#include "firmware/stripe/pixel_window.h"

namespace stria::fast {

/// What one row has found beside the first pulse of each of its pixels, which is in PulsePlanes.
struct RowFinds {
    std::vector<Pulse> others;
    SampleHistogram effective{};  ///< of a band's first row: of all that its kernels judged
    std::uint32_t saturated_samples = 0;
    int needed = 0;  ///< latest frames that open or waiting windows reach back into
    WindowCounts windows;
};

/// One clean pulse of each pixel, a plane for each of its numbers: neighbours are written together.
class PulsePlanes {
  public:
    /// Row y's pulses by pixel; their units as Pulse's. Width 0: none. Rows are padded to kLanes.
    struct Row {
        TimeNs* t_ns;
        float *amplitude, *width, *background, *sigma, *chi_square;
    };

    PulsePlanes(int width, int height)
        : stride_((static_cast<std::size_t>(width) + kLanes - 1) / kLanes * kLanes),
          plane_(stride_ * static_cast<std::size_t>(height)),
          times_(std::make_unique_for_overwrite<TimeNs[]>(plane_)),
          others_(std::make_unique_for_overwrite<float[]>(4 * plane_)) {
        ask_for_large_pages(times_.get(), plane_ * sizeof(TimeNs));
        ask_for_large_pages(others_.get(), 4 * plane_ * sizeof(float));
        widths_.reserve(plane_);
        ask_for_large_pages(widths_.data(), plane_ * sizeof(float));
        widths_.resize(plane_);
    }

    Row row(int y) {
        const std::size_t at = stride_ * static_cast<std::size_t>(y);
        float* const first = others_.get() + at;
        return {times_.get() + at, first, widths_.data() + at, first + plane_, first + 2 * plane_,
                first + 3 * plane_};
    }
    /// Asks memory for kLanes places from x on, to be written.
    void prefetch(int x, int y) {
        const Row of = row(y);
        __builtin_prefetch(of.t_ns + x, 1);
        __builtin_prefetch(of.t_ns + x + kLanes / 2, 1);
        for (const float* plane : {of.amplitude, of.width, of.background, of.sigma, of.chi_square})
            __builtin_prefetch(plane + x, 1);
    }

  private:
    std::size_t stride_, plane_;
    std::unique_ptr<TimeNs[]> times_;  // read only where a width says that there is a pulse
    std::unique_ptr<float[]> others_;
    std::vector<float> widths_;
};

}  // namespace stria::fast

#pragma once
#include <cstdint>
#include <vector>

#include "firmware/core/frame.h"
#include "firmware/stripe/row_peaks.h"

namespace stria {

/// Looks at a few rows and columns of a sweep's frames for how far the stripe moves from one frame
/// to the next and how wide it is, px. Rows answer for stripes that run across them, columns for
/// the others.
class SweepProbe {
  public:
    SweepProbe(int width, int height, int bits, const SensorNoise& noise);
    void add(const Frame& frame);
    /// Medians; 0 where no two successive frames showed the stripe in the same line.
    double step_px() const;
    double width_px() const;

  private:
    /// Strongest peak of one line in the frame before, and all steps and widths so far.
    struct Lines {
        std::vector<int> at;
        std::vector<float> last_px;  ///< below -1: none
        std::vector<float> steps_px, widths_px;
    };
    template <typename T>
    void look(const Frame& frame, const ImageView<const T>& view);
    void note(Lines& lines, std::size_t i, const std::vector<Pulse>& peaks);
    const Lines& better() const;

    Lines rows_, columns_;
    RowPeakFinder row_finder_, column_finder_;
    std::vector<std::uint16_t> line_;
    std::vector<Pulse> peaks_;
};

}  // namespace stria

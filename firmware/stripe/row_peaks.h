#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/core/pulse.h"
#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/peak_methods.h"
#include "firmware/stripe/spatial.h"

namespace stria {

constexpr int kMinRowLength = 8;  ///< px; shorter rows have no room for a stripe and its sides

/// Finds the stripe's peaks in one row after another; keeps its work space from row to row.
class RowPeakFinder {
  public:
    RowPeakFinder(int width, int full_scale, const SensorNoise& noise,
                  const SpatialOptions& options);

    /// Appends the row's peaks, strongest first: u, amplitude, width, background, sigma, chi-square
    /// and flags; the rest is the caller's. T is uint8_t or uint16_t.
    template <typename T>
    void find(const T* row, std::vector<Pulse>& peaks);

  private:
    /// A place that stands out from both its sides.
    struct Candidate {
        int x;
        int box;           ///< width of the window that answered most, px
        float answer;      ///< squared detection signal-to-noise
        float background;  ///< DN, mean of both sides
    };

    void detect();
    void detect_at(int box);
    float mean_or_dark(int begin, int count) const;
    void judge(int x, int box, float on_left, float on_right);
    void choose_candidates();
    bool is_covered(int x, const std::vector<Pulse>& peaks, std::size_t first) const;
    void fit(const Candidate& candidate, std::vector<Pulse>& peaks, std::size_t first);
    void move_to_places(std::vector<Pulse>& peaks, std::size_t first) const;

    int width_, full_scale_;
    const SensorNoise noise_;
    const SpatialOptions options_;
    std::vector<int> boxes_;
    std::vector<float> values_;       ///< the row, DN
    std::vector<std::int32_t> sums_;  ///< sums_[x] = row[0] + ... + row[x - 1]
    std::vector<float> answer_;       ///< squared detection signal-to-noise, best over all boxes
    std::vector<float> background_;
    std::vector<int> box_;
    std::vector<Candidate> candidates_;
    std::vector<std::optional<PlacedPeak>> places_;  ///< of the row's peaks, by options.method
};

}  // namespace stria

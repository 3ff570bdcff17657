#include "firmware/stripe/sweep_probe.h"
#include "firmware/core/median.h"

#include <cmath>

namespace stria {
namespace {

constexpr int kLines = 7;
constexpr float kNone = -1e9f;
const SpatialOptions kProbeOptions = {.max_peaks_per_row = 1, .max_width_px = 16.0};

std::vector<int> spread_over(int length) {
    std::vector<int> at;
    for (int i = 1; i <= kLines; ++i) at.push_back(length * i / (kLines + 1));
    at.erase(std::unique(at.begin(), at.end()), at.end());
    return at;
}

}  // namespace

SweepProbe::SweepProbe(int width, int height, int bits, const SensorNoise& noise)
    : row_finder_(width, (1 << bits) - 1, noise, kProbeOptions),
      column_finder_(height, (1 << bits) - 1, noise, kProbeOptions) {
    rows_.at = spread_over(height);
    rows_.last_px.assign(rows_.at.size(), kNone);
    columns_.at = spread_over(width);
    columns_.last_px.assign(columns_.at.size(), kNone);
}

void SweepProbe::add(const Frame& frame) {
    if (frame.bits > 8)
        look(frame, frame.view16());
    else
        look(frame, frame.view8());
}

template <typename T>
void SweepProbe::look(const Frame& frame, const ImageView<const T>& view) {
    for (std::size_t i = 0; frame.width >= kMinRowLength && i < rows_.at.size(); ++i) {
        peaks_.clear();
        row_finder_.find(view.row(rows_.at[i]), peaks_);
        note(rows_, i, peaks_);
    }
    line_.resize(static_cast<std::size_t>(frame.height));
    for (std::size_t i = 0; frame.height >= kMinRowLength && i < columns_.at.size(); ++i) {
        for (int y = 0; y < frame.height; ++y) line_[y] = view.at(columns_.at[i], y);
        peaks_.clear();
        column_finder_.find(line_.data(), peaks_);
        note(columns_, i, peaks_);
    }
}

void SweepProbe::note(Lines& lines, std::size_t i, const std::vector<Pulse>& peaks) {
    if (peaks.empty()) {
        lines.last_px[i] = kNone;
        return;
    }
    if (lines.last_px[i] > kNone) {
        lines.steps_px.push_back(std::abs(peaks[0].u - lines.last_px[i]));
        lines.widths_px.push_back(peaks[0].width);
    }
    lines.last_px[i] = peaks[0].u;
}

/// The direction in which more peaks were seen to move.
const SweepProbe::Lines& SweepProbe::better() const {
    return rows_.steps_px.size() >= columns_.steps_px.size() ? rows_ : columns_;
}

double SweepProbe::step_px() const { return median(better().steps_px); }

double SweepProbe::width_px() const { return median(better().widths_px); }

}  // namespace stria

#include "firmware/stripe/spacetime.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "firmware/stripe/fast_spacetime.h"
#include "firmware/stripe/gaussian_fit.h"
#include "firmware/stripe/option_check.h"
#include "firmware/stripe/pixel_tracker.h"
#include "firmware/stripe/spacetime_engine.h"

namespace stria {
namespace {

/// The reference: pixel by pixel, in double precision.
template <typename T>
class ReferenceEngine final : public SpacetimeEngine {
  public:
    ReferenceEngine(int width, int height, int bits, const SensorNoise& noise,
                    const SpacetimeOptions& options)
        : SpacetimeEngine(width, height, bits, noise, options, {}) {
        rows_.reserve(static_cast<std::size_t>(height));
        for (int y = 0; y < height; ++y)
            rows_.emplace_back(width, y, (1 << bits) - 1, noise, options);
    }
    WindowCounts windows() const override {
        WindowCounts counts;
        for (const PixelTracker<T>& row : rows_) counts.all += row.windows;
        counts.by_reference = counts.all;
        return counts;
    }

  private:
    void advance_rows(int first, int last, int begin, int end) override {
        for (int y = first; y < last; ++y) rows_[y].advance(frames_, begin, end);
    }
    void finish_rows(int first, int last) override {
        for (int y = first; y < last; ++y) {
            rows_[y].finish(frames_);
            tidy_row(rows_[y].pulses);
        }
    }
    int oldest_needed(int otherwise) const override {
        for (const PixelTracker<T>& row : rows_) otherwise = row.oldest_needed(otherwise);
        return otherwise;
    }
    Row row(int y) const override { return {&rows_[y].effective, rows_[y].saturated_samples}; }
    void append_widths(int y, std::vector<float>& widths) override {
        for (const Pulse& pulse : rows_[y].pulses) widths.push_back(pulse.width);
    }
    void append_row(int y, const WidthLimits& limits, PulseMap& map) override {
        auto pulse = rows_[y].pulses.begin();
        const auto end = rows_[y].pulses.end();
        for (int x = 0; x < width_; ++x) {
            for (; pulse != end && static_cast<int>(pulse->u) == x; ++pulse)
                append(*pulse, limits, map);
            end_cell(x, y, map);
        }
    }

    std::vector<PixelTracker<T>> rows_;
};

}  // namespace

void SpacetimeOptions::validate() const {
    const OptionCheck require{"SpacetimeOptions"};
    require(min_snr > 0, "min_snr", min_snr, "above 0");
    require(min_amplitude_dn >= 0, "min_amplitude_dn", min_amplitude_dn, "0 or more");
    require(max_pulses_per_cell >= 1 && max_pulses_per_cell <= kMaxPulsesPerCell,
            "max_pulses_per_cell", max_pulses_per_cell, "1 to 4");
    require(max_pulse_frames >= 4, "max_pulse_frames", max_pulse_frames, "4 or more");
    require(history_frames >= 4, "history_frames", history_frames, "4 or more");
    require(max_pulse_frames + 2 * history_frames < kMaxFitSamples, "max_pulse_frames",
            max_pulse_frames, "with twice history_frames less than 192");
    require(max_misfit > 0, "max_misfit", max_misfit, "above 0");
    require(width_ratio > 1, "width_ratio", width_ratio, "above 1");
    require(threads >= 1, "threads", threads, "1 or more");
    require(sequence_step >= 1, "sequence_step", sequence_step, "1 or more");
}

SpacetimeAnalyser::SpacetimeAnalyser(int width, int height, int bits, const SensorNoise& noise,
                                     const SpacetimeOptions& options) {
    options.validate();
    if (width < 1 || width > kMaxFrameSide || height < 1 || height > kMaxFrameSide || bits < 8 ||
        bits > 16)
        throw std::invalid_argument("SpacetimeAnalyser: " + std::to_string(width) + " x " +
                                    std::to_string(height) + ", " + std::to_string(bits) +
                                    " bits: expected sides of 1 to " +
                                    std::to_string(kMaxFrameSide) + " and 8 to 16 bits");
    if (bits > 8)
        engine_ =
            std::make_unique<ReferenceEngine<std::uint16_t>>(width, height, bits, noise, options);
    else if (options.fast)
        engine_ = make_fast_engine(width, height, noise, options);
    else
        engine_ =
            std::make_unique<ReferenceEngine<std::uint8_t>>(width, height, bits, noise, options);
}

SpacetimeAnalyser::~SpacetimeAnalyser() = default;
SpacetimeAnalyser::SpacetimeAnalyser(SpacetimeAnalyser&&) noexcept = default;
SpacetimeAnalyser& SpacetimeAnalyser::operator=(SpacetimeAnalyser&&) noexcept = default;

void SpacetimeAnalyser::add(const Frame& frame) { engine_->add(frame); }
void SpacetimeAnalyser::add(Frame&& frame) { engine_->add(std::move(frame)); }
std::optional<Frame> SpacetimeAnalyser::take_spare() { return engine_->take_spare(); }
PulseMap SpacetimeAnalyser::finish() { return engine_->finish(); }
const SweepSampling& SpacetimeAnalyser::sampling() const { return engine_->sampling(); }
WindowCounts SpacetimeAnalyser::windows() const { return engine_->windows(); }
int SpacetimeAnalyser::most_frames() const { return engine_->most_frames(); }
int SpacetimeAnalyser::frames_ignored() const { return engine_->frames_ignored(); }

}  // namespace stria

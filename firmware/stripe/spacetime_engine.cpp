#include "firmware/stripe/spacetime_engine.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <string>

#include "firmware/stripe/large_pages.h"
#include "firmware/stripe/row_bands.h"

namespace stria {
namespace {

constexpr double kUndersampled = 1.6;        // effective samples: a width of 0.45 frame periods
constexpr std::uint32_t kFewestPulses = 32;  // to judge the sampling by
constexpr std::size_t kFewestWidths = 100;   // to judge widths by their median

float strength(const Pulse& p) { return p.amplitude * std::sqrt(p.width); }

/// The row's pulses by pixel; those of a pixel by strength, then time.
void sort_row(std::vector<Pulse>& pulses, int width) {
    thread_local std::vector<std::uint32_t> place;
    thread_local std::vector<Pulse> sorted;
    place.assign(static_cast<std::size_t>(width) + 1, 0);
    for (const Pulse& pulse : pulses) ++place[static_cast<std::size_t>(pulse.u) + 1];
    for (std::size_t x = 1; x < place.size(); ++x) place[x] += place[x - 1];
    sorted.resize(pulses.size());
    for (const Pulse& pulse : pulses) sorted[place[static_cast<std::size_t>(pulse.u)]++] = pulse;
    std::swap(pulses, sorted);
    const auto by_strength = [](const Pulse& a, const Pulse& b) {
        return strength(a) != strength(b) ? strength(a) > strength(b) : a.t_ns < b.t_ns;
    };
    for (auto begin = pulses.begin(); begin != pulses.end();) {
        auto end = begin + 1;
        while (end != pulses.end() && end->u == begin->u) ++end;
        if (end - begin > 1) std::sort(begin, end, by_strength);
        begin = end;
    }
}

/// Drops those of a sorted row's pulses that two windows found twice, keeps the strongest `most` of
/// a pixel and suspects weak second ones.
void tidy_cells(std::vector<Pulse>& pulses, int most) {
    std::size_t kept = 0, cell = 0;
    for (const Pulse& pulse : pulses) {
        if (kept == cell || pulses[cell].u != pulse.u) cell = kept;
        const auto begin = pulses.begin() + static_cast<std::ptrdiff_t>(cell);
        const auto end = pulses.begin() + static_cast<std::ptrdiff_t>(kept);
        const bool known = std::any_of(begin, end, [&](const Pulse& other) {
            // The narrower one's width: a pulse may stand on another surface's broad light.
            return std::abs(static_cast<double>(other.t_ns - pulse.t_ns)) <
                   std::min(other.width, pulse.width);
        });
        if (known || kept - cell >= static_cast<std::size_t>(most)) continue;
        const bool weak = kept > cell && pulse.amplitude < 0.5f * pulses[cell].amplitude;
        pulses[kept] = pulse;
        if (weak) pulses[kept].flags |= kPulseGhostSuspected;
        ++kept;
    }
    pulses.resize(kept);
}

/// The width with half of the others below it, positive all: counted by the leading bits, then, of
/// those that share them, by the others.
float median_width(const std::vector<float>& widths) {
    const auto bits = [](float width) { return std::bit_cast<std::uint32_t>(width); };
    std::size_t below = widths.size() / 2;
    const auto bin_of = [&below](const std::vector<std::uint32_t>& counts) {
        std::uint32_t bin = 0;
        while (counts[bin] <= below) below -= counts[bin++];
        return bin;
    };
    std::vector<std::uint32_t> counts(1u << 16);
    for (const float width : widths) ++counts[bits(width) >> 16];
    const std::uint32_t leading = bin_of(counts);
    counts.assign(counts.size(), 0);
    for (const float width : widths)
        if (bits(width) >> 16 == leading) ++counts[bits(width) & 0xffffu];
    return std::bit_cast<float>((leading << 16) | bin_of(counts));
}

double median_of(const SampleHistogram& histogram, std::uint32_t total) {
    std::uint32_t below = 0;
    for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
        below += histogram[bin];
        if (2 * below >= total) return 1.0 + 0.05 * static_cast<double>(bin);
    }
    return 0;
}

}  // namespace

SpacetimeEngine::SpacetimeEngine(int width, int height, int bits, const SensorNoise& noise,
                                 const SpacetimeOptions& options, const Pace& pace)
    : width_(width),
      height_(height),
      bits_(bits),
      options_(options),
      pace_(pace),
      probe_(width, height, bits, noise) {}

bool SpacetimeEngine::accept(const Frame& frame) {
    if (frame.width != width_ || frame.height != height_ || frame.bits != bits_)
        throw std::invalid_argument("SpacetimeAnalyser: frame of " + std::to_string(frame.width) +
                                    " x " + std::to_string(frame.height) + ", " +
                                    std::to_string(frame.bits) + " bits: expected " +
                                    std::to_string(width_) + " x " + std::to_string(height_) +
                                    ", " + std::to_string(bits_) + " bits");
    if (!follower_.accept(frame, options_.sequence_step)) return false;
    camera_id_ = frame.camera_id;
    const int k = frames_.count();
    if (k < pace_.probed_at_first || k % pace_.probe_every < 2) probe_.add(frame);
    return true;
}

void SpacetimeEngine::analyse_if_due() {
    most_frames_ = std::max(most_frames_, frames_.count() - frames_.first());
    if (frames_.count() - analysed_ >= pace_.frames_together) analyse();
}

PulseMap SpacetimeEngine::finish() {
    if (frames_.count() > analysed_) analyse();
    PulseMap map;
    map.mode = StripeMode::spacetime;
    map.width = width_;
    map.height = height_;
    map.camera_id = camera_id_;
    map.frames = static_cast<std::uint32_t>(frames_.count());
    map.frames_dropped = follower_.dropped();
    for_row_bands(height_, options_.threads,
                  [&](int first, int last) { finish_rows(first, last); });
    frames_.release_before(frames_.count());
    judge_sampling(map);
    assemble(map);
    return map;
}

void SpacetimeEngine::analyse() {
    const int begin = analysed_, end = frames_.count();
    begin_pass(end);
    for_row_bands(height_, options_.threads,
                  [&](int first, int last) { advance_rows(first, last, begin, end); });
    analysed_ = end;
    frames_.release_before(oldest_needed(end - options_.history_frames));
}

void SpacetimeEngine::tidy_row(std::vector<Pulse>& pulses) const {
    if (pulses.empty()) return;
    sort_row(pulses, width_);
    tidy_cells(pulses, options_.max_pulses_per_cell);
}

void SpacetimeEngine::judge_sampling(PulseMap& map) {
    SampleHistogram all{};
    std::uint32_t total = 0;
    for (int y = 0; y < height_; ++y) {
        const Row of_row = row(y);
        for (std::size_t bin = 0; bin < all.size(); ++bin) {
            all[bin] += (*of_row.effective)[bin];
            total += (*of_row.effective)[bin];
        }
        map.saturated_samples += of_row.saturated_samples;
    }
    sampling_.samples_per_pulse = total > 0 ? median_of(all, total) : 0.0;
    sampling_.step_px = probe_.step_px();
    sampling_.width_px = probe_.width_px();
    map.undersampled = total >= kFewestPulses && sampling_.samples_per_pulse < kUndersampled;
}

void SpacetimeEngine::assemble(PulseMap& map) {
    map.cell_begin.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) + 1,
                          0);
    if (map.undersampled) return;
    std::vector<float> widths;
    widths.reserve(map.cell_begin.size());
    for (int y = 0; y < height_; ++y) append_widths(y, widths);
    map.pulses.reserve(widths.size());
    ask_for_large_pages(map.pulses.data(), widths.size() * sizeof(Pulse));
    WidthLimits limits;
    if (widths.size() >= kFewestWidths) {
        const double median = median_width(widths);
        limits.least = static_cast<float>(median / options_.width_ratio);
        limits.most = static_cast<float>(median * options_.width_ratio);
    }
    for (int y = 0; y < height_; ++y) append_row(y, limits, map);
}

}  // namespace stria

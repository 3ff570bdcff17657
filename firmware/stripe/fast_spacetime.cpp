#include "firmware/stripe/fast_spacetime.h"

#include <algorithm>
#include <array>
#include <vector>

#include "firmware/stripe/detection_levels.h"
#include "firmware/stripe/fast_groups.h"
#include "firmware/stripe/fast_planes.h"
#include "firmware/stripe/large_pages.h"

namespace stria {
namespace {

using fast::kBatch;
using fast::kPadding;

constexpr std::size_t kAhead = 32;  // pulses of the map
constexpr SpacetimeEngine::Pace kPace = {
    .frames_together = 16, .probed_at_first = 8, .probe_every = 64};

class FastEngine final : public SpacetimeEngine {
  public:
    FastEngine(int width, int height, const SensorNoise& noise, const SpacetimeOptions& options)
        : SpacetimeEngine(width, height, 8, noise, options, kPace),
          noise_(noise),
          levels_(8, noise, options.min_snr, options.min_amplitude_dn),
          limits_{options.max_pulse_frames, options.history_frames},
          stride_(static_cast<std::size_t>((width + kPadding - 1) / kPadding * kPadding)),
          pulses_(width, height),
          rows_(static_cast<std::size_t>(height)) {
        const std::size_t size =
            fast::RowPlanes::kCount * stride_ * static_cast<std::size_t>(height) + kPadding;
        planes_.reserve(size);
        ask_for_large_pages(planes_.data(), size);
        planes_.resize(size);
    }

    WindowCounts windows() const override {
        WindowCounts sum;
        for (const fast::RowFinds& row : rows_) {
            sum.all += row.windows.all;
            sum.by_reference += row.windows.by_reference;
        }
        return sum;
    }

  private:
    /// The row's planes, one behind the other, on cache lines.
    fast::RowPlanes planes(int y) {
        const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(planes_.data());
        std::uint8_t* row = planes_.data() + (kPadding - begin % kPadding) % kPadding +
                            fast::RowPlanes::kCount * stride_ * static_cast<std::size_t>(y);
        return fast::RowPlanes::at(row, stride_);
    }

    void begin_pass(int end) override {
        if (period_ns_ > 0) return;
        const Frame& first = frames_.at(0);
        const Frame& last = frames_.at(end - 1);
        period_ns_ =
            end < 2 ? 1.0 : static_cast<double>(last.row_time(0) - first.row_time(0)) / (end - 1);
        laser_id_ = first.laser_id;
        exposure_index_ = first.exposure_index;
    }
    /// @param fresh  first of the frames whose rows the fits follow at once
    fast::FitSetting setting(int fresh) const {
        return {frames_, noise_, options_,  period_ns_,     width_,
                height_, fresh,  laser_id_, exposure_index_};
    }

    void advance_rows(int first, int last, int begin, int end) override {
        fast::GroupFits fits(setting(begin), pulses_, rows_);
        std::vector<fast::Closed> others;
        for (int y = first; y < last; ++y) {
            others.clear();
            for (int k = begin; k < end; k += kBatch)
                advance_row(y, k, std::min(end, k + kBatch), others);
            // A row's windows are fitted while memory fetches the next one's.
            fits.queue(y, planes(y), false);
            for (const fast::Closed& window : others) fits.queue(y, planes(y), window);
            fits.fit_queued();
            fits.flip();
        }
        fits.fit_queued();
        fits.add_effective(rows_[static_cast<std::size_t>(first)].effective);
    }

    void advance_row(int y, int begin, int end, std::vector<fast::Closed>& others) {
        std::array<const std::uint8_t*, kBatch> rows;
        const int count = end - begin;
        for (int i = 0; i < count; ++i)
            rows[static_cast<std::size_t>(i)] = row_of<std::uint8_t>(frames_.at(begin + i), y);
        const fast::RowPlanes row = planes(y);
        const auto number = static_cast<std::uint8_t>(begin);
        fast::RowState state;
        if (count == kBatch) {
            if (begin == 0) fast::set_backgrounds(rows.data(), width_, row, levels_);
            state = fast::advance_row(rows.data(), width_, row, levels_, limits_, number, others);
        } else {
            if (begin == 0)
                fast::set_backgrounds_plainly(rows.data(), count, 0, width_, row, levels_);
            state = fast::advance_row_plainly(rows.data(), count, width_, row, levels_, limits_,
                                              number, others);
        }
        fast::RowFinds& finds = rows_[static_cast<std::size_t>(y)];
        finds.saturated_samples += state.saturated_samples;
        finds.needed = state.oldest > 0 ? state.oldest + limits_.history_frames : 0;
    }

    void finish_rows(int first, int last) override {
        if (frames_.count() == 0) return;
        fast::GroupFits fits(setting(frames_.count()), pulses_, rows_);
        for (int y = first; y < last; ++y) {
            const fast::RowPlanes row = planes(y);
            fits.queue(y, row, true);
            fits.flip();
            fits.fit_queued();
            for (int x = 0; x < width_; ++x)
                if (row.age[x] > 0) fits.take_plainly(open_window(x, y, row));
            gather_cells(y);
        }
        fits.add_effective(rows_[static_cast<std::size_t>(first)].effective);
    }

    /// Puts the pulses of pixels that have several together, and tidies them.
    void gather_cells(int y) {
        std::vector<Pulse>& others = rows_[static_cast<std::size_t>(y)].others;
        const fast::PulsePlanes::Row row = pulses_.row(y);
        for (std::size_t i = 0, count = others.size(); i < count; ++i) {
            const int x = static_cast<int>(others[i].u);
            if (row.width[x] == 0) continue;
            fill_clean(others.emplace_back(), x, y, row, 0);
            row.width[x] = 0;
        }
        tidy_row(others);
    }

    /// Written in place: a copy would wait for its parts.
    void fill_clean(Pulse& pulse, int x, int y, const fast::PulsePlanes::Row& row,
                    std::uint16_t flags) const {
        pulse.u = static_cast<float>(x);
        pulse.v = static_cast<float>(y);
        pulse.t_ns = row.t_ns[x];
        pulse.amplitude = row.amplitude[x];
        pulse.width = row.width[x];
        pulse.background = row.background[x];
        pulse.sigma = row.sigma[x];
        pulse.chi_square = row.chi_square[x];
        pulse.flags = flags;
        pulse.laser_id = laser_id_;
        pulse.exposure_index = exposure_index_;
    }

    PixelWindow open_window(int x, int y, const fast::RowPlanes& row) const {
        const int first_above = frames_.count() - row.age[x];
        const int last = row.age[x] - 1 - row.quiet[x];
        PixelWindow window;
        window.x = x;
        window.y = y;
        window.begin =
            std::max({first_above - fast::margin_frames(last, limits_), frames_.first(), 0});
        window.end = frames_.count();
        window.background = static_cast<float>(row.background(x)) / 256.0f;
        window.level = static_cast<float>(levels_.threshold(row.background(x))) + 1.0f;
        window.at_sequence_end = true;
        return window;
    }

    int oldest_needed(int otherwise) const override {
        int needed = 0;
        for (const fast::RowFinds& row : rows_) needed = std::max(needed, row.needed);
        return std::max(std::min(otherwise, frames_.count() - needed), 0);
    }
    Row row(int y) const override {
        const fast::RowFinds& finds = rows_[static_cast<std::size_t>(y)];
        return {&finds.effective, finds.saturated_samples};
    }
    void append_widths(int y, std::vector<float>& widths) override {
        const float* of_row = pulses_.row(y).width;
        for (int x = 0; x < width_; ++x)
            if (of_row[x] != 0) widths.push_back(of_row[x]);
        for (const Pulse& pulse : rows_[static_cast<std::size_t>(y)].others)
            widths.push_back(pulse.width);
    }
    void append_row(int y, const WidthLimits& limits, PulseMap& map) override {
        const fast::PulsePlanes::Row row = pulses_.row(y);
        const std::vector<Pulse>& others = rows_[static_cast<std::size_t>(y)].others;
        const std::size_t most = map.pulses.capacity();
        auto other = others.begin();
        for (int x = 0; x < width_; ++x) {
            const float width = row.width[x];
            if (width != 0) {
                // Stores alone ask memory for a few lines at a time.
                if (map.pulses.size() + kAhead < most)
                    __builtin_prefetch(map.pulses.data() + map.pulses.size() + kAhead, 1);
                fill_clean(map.pulses.emplace_back(), x, y, row, limits.flag(width));
            }
            for (; other != others.end() && static_cast<int>(other->u) == x; ++other)
                append(*other, limits, map);
            end_cell(x, y, map);
        }
    }

    SensorNoise noise_;
    DetectionLevels levels_;
    fast::WindowLimits limits_;
    double period_ns_ = 0;  ///< of the first pass: unit of the kernels' times
    std::uint8_t laser_id_ = 0, exposure_index_ = 0;
    std::size_t stride_;
    std::vector<std::uint8_t> planes_;
    fast::PulsePlanes pulses_;
    std::vector<fast::RowFinds> rows_;
};

}  // namespace

std::unique_ptr<SpacetimeEngine> make_fast_engine(int width, int height, const SensorNoise& noise,
                                                  const SpacetimeOptions& options) {
    return std::make_unique<FastEngine>(width, height, noise, options);
}

}  // namespace stria

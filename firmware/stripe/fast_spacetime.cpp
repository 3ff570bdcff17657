#include "firmware/stripe/fast_spacetime.h"

#include <algorithm>
#include <array>
#include <vector>

#include "firmware/stripe/detection_levels.h"
#include "firmware/stripe/fast_windows.h"

namespace stria {
namespace {

using fast::kBatch;
using fast::kPadding;

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
          planes_(5 * stride_ * static_cast<std::size_t>(height) + kPadding),
          rows_(static_cast<std::size_t>(height)) {}

    WindowCounts windows() const override {
        WindowCounts sum;
        for (const fast::RowFinds& row : rows_) {
            sum.all += row.windows.all;
            sum.by_reference += row.windows.by_reference;
        }
        return sum;
    }

  private:
    /// The row's five planes, one behind the other, on cache lines.
    fast::RowPlanes planes(int y) {
        const std::uintptr_t begin = reinterpret_cast<std::uintptr_t>(planes_.data());
        std::uint8_t* row = planes_.data() + (kPadding - begin % kPadding) % kPadding +
                            5 * stride_ * static_cast<std::size_t>(y);
        return {row, row + stride_, row + 2 * stride_, row + 3 * stride_, row + 4 * stride_};
    }

    /// The windows of a row that closed in the frames from `begin` on.
    struct Batch {
        int y = 0, begin = 0;
        std::vector<fast::Closed> windows;
    };
    static void take(const Batch& batch, fast::WindowBins& bins) {
        for (const fast::Closed& window : batch.windows)
            bins.take(batch.y, batch.begin + window.at, window);
    }

    void advance_rows(int first, int last, int begin, int end) override {
        fast::WindowBins bins({frames_, noise_, options_}, begin, end, rows_);
        // A batch's windows are gathered while memory fetches the next one's.
        Batch last_batch, batch;
        for (int y = first; y < last; ++y)
            for (int k = begin; k < end; k += kBatch) {
                batch.y = y;
                batch.begin = k;
                batch.windows.clear();
                advance_row(y, k, std::min(end, k + kBatch), batch.windows);
                bins.prefetch(y, k, batch.windows);
                take(last_batch, bins);
                std::swap(batch, last_batch);
            }
        take(last_batch, bins);
        bins.flush();
    }

    void advance_row(int y, int begin, int end, std::vector<fast::Closed>& closed) {
        std::array<const std::uint8_t*, kBatch> rows;
        const int count = end - begin;
        for (int i = 0; i < count; ++i)
            rows[static_cast<std::size_t>(i)] = row_of<std::uint8_t>(frames_.at(begin + i), y);
        const fast::RowPlanes planes_of_row = planes(y);
        if (begin == 0) set_backgrounds(rows.data(), count, planes_of_row);
        const fast::RowState state =
            count == kBatch
                ? fast::advance_row(rows.data(), width_, planes_of_row, levels_, limits_, closed)
                : fast::advance_row_plainly(rows.data(), count, width_, planes_of_row, levels_,
                                            limits_, closed);
        fast::RowFinds& finds = rows_[static_cast<std::size_t>(y)];
        finds.saturated_samples += state.saturated_samples;
        finds.oldest = state.oldest;
    }

    void set_backgrounds(const std::uint8_t* const* rows, int count,
                         const fast::RowPlanes& planes_of_row) const {
        for (int x = 0; x < width_; ++x) {
            DetectionLevels::FirstSamples samples(rows[0][x]);
            for (int k = 1; k < count; ++k) samples.add(rows[k][x]);
            planes_of_row.set_background(x, levels_.first(samples));
            planes_of_row.threshold[x] =
                static_cast<std::uint8_t>(levels_.threshold(planes_of_row.background(x)));
        }
    }

    void finish_rows(int first, int last) override {
        if (frames_.count() == 0) return;
        fast::WindowBins bins({frames_, noise_, options_}, frames_.count() - 1, frames_.count(),
                              rows_);
        for (int y = first; y < last; ++y) {
            const fast::RowPlanes row = planes(y);
            for (int x = 0; x < width_; ++x)
                if (row.age[x] > 0) bins.take_plainly(open_window(x, y, row));
        }
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
        window.level = static_cast<float>(row.threshold[x]) + 1.0f;
        window.at_sequence_end = true;
        return window;
    }

    int oldest_needed(int otherwise) const override {
        int oldest = 0;
        for (const fast::RowFinds& row : rows_) oldest = std::max(oldest, row.oldest);
        return std::max(std::min(otherwise, frames_.count() - oldest - limits_.history_frames), 0);
    }
    Row row(int y) override {
        fast::RowFinds& finds = rows_[static_cast<std::size_t>(y)];
        return {&finds.pulses, &finds.effective, finds.saturated_samples};
    }

    SensorNoise noise_;
    DetectionLevels levels_;
    fast::WindowLimits limits_;
    std::size_t stride_;
    std::vector<std::uint8_t> planes_;
    std::vector<fast::RowFinds> rows_;
};

}  // namespace

std::unique_ptr<SpacetimeEngine> make_fast_engine(int width, int height, const SensorNoise& noise,
                                                  const SpacetimeOptions& options) {
    return std::make_unique<FastEngine>(width, height, noise, options);
}

}  // namespace stria

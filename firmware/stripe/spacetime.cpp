#include "firmware/stripe/spacetime.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/stripe/frame_follower.h"
#include "firmware/stripe/gaussian_fit.h"
#include "firmware/stripe/pixel_tracker.h"
#include "firmware/stripe/row_bands.h"
#include "firmware/stripe/sweep_probe.h"

namespace stria {
namespace {

constexpr int kBatch = 8;              // frames analysed together, so that a row stays in the cache
constexpr int kProbedAtFirst = 32;     // frames all of which the probe sees; later two of 32
constexpr double kUndersampled = 1.6;  // effective samples: a width of 0.45 frame periods
constexpr std::uint32_t kFewestPulses = 32;  // to judge the sampling by
constexpr std::size_t kFewestWidths = 100;   // to judge widths by their median

void require(bool holds, const char* field, double value, const char* bound) {
    if (!holds)
        throw std::invalid_argument(std::string("SpacetimeOptions.") + field + " = " +
                                    std::to_string(value) + ": expected " + bound);
}

float strength(const Pulse& p) { return p.amplitude * std::sqrt(p.width); }

/// Sorts a row's pulses by pixel and strength, drops those that two windows found twice, keeps the
/// strongest `most` of a pixel and suspects weak second ones.
void tidy_row(std::vector<Pulse>& pulses, int most) {
    std::stable_sort(pulses.begin(), pulses.end(), [](const Pulse& a, const Pulse& b) {
        return a.u != b.u ? a.u < b.u : strength(a) > strength(b);
    });
    std::size_t kept = 0, cell = 0;
    for (const Pulse& pulse : pulses) {
        if (kept == cell || pulses[cell].u != pulse.u) cell = kept;
        const auto begin = pulses.begin() + static_cast<std::ptrdiff_t>(cell);
        const auto end = pulses.begin() + static_cast<std::ptrdiff_t>(kept);
        const bool known = std::any_of(begin, end, [&](const Pulse& other) {
            return std::abs(static_cast<double>(other.t_ns - pulse.t_ns)) < other.width;
        });
        if (known || kept - cell >= static_cast<std::size_t>(most)) continue;
        const bool weak = kept > cell && pulse.amplitude < 0.5f * pulses[cell].amplitude;
        pulses[kept] = pulse;
        if (weak) pulses[kept].flags |= kPulseGhostSuspected;
        ++kept;
    }
    pulses.resize(kept);
}

void flag_widths(std::vector<Pulse>& pulses, double ratio) {
    if (pulses.size() < kFewestWidths) return;
    std::vector<float> widths;
    for (const Pulse& pulse : pulses) widths.push_back(pulse.width);
    const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
    std::nth_element(widths.begin(), middle, widths.end());
    for (Pulse& pulse : pulses)
        if (pulse.width > *middle * ratio || pulse.width * ratio < *middle)
            pulse.flags |= kPulseWidthOutOfRange;
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

void SpacetimeOptions::validate() const {
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

/// What is the same for both sample types; the trackers are behind it.
class SpacetimeAnalyser::Engine {
  public:
    Engine(int width, int height, int bits, const SensorNoise& noise,
           const SpacetimeOptions& options)
        : width_(width),
          height_(height),
          bits_(bits),
          options_(options),
          probe_(width, height, bits, noise) {}
    virtual ~Engine() = default;

    void add(const Frame& frame) {
        if (frame.width != width_ || frame.height != height_ || frame.bits != bits_)
            throw std::invalid_argument(
                "SpacetimeAnalyser: frame of " + std::to_string(frame.width) + " x " +
                std::to_string(frame.height) + ", " + std::to_string(frame.bits) +
                " bits: expected " + std::to_string(width_) + " x " + std::to_string(height_) +
                ", " + std::to_string(bits_) + " bits");
        if (!follower_.accept(frame, options_.sequence_step)) return;
        camera_id_ = frame.camera_id;
        const int k = frames_.count();
        if (k < kProbedAtFirst || k % 32 < 2) probe_.add(frame);
        frames_.add(frame);
        if (frames_.count() - analysed_ >= kBatch) analyse();
    }

    PulseMap finish() {
        if (frames_.count() > analysed_) analyse();
        PulseMap map;
        map.mode = StripeMode::spacetime;
        map.width = width_;
        map.height = height_;
        map.camera_id = camera_id_;
        map.frames = static_cast<std::uint32_t>(frames_.count());
        map.frames_dropped = follower_.dropped();
        close_windows();
        judge_sampling(map);
        assemble(map);
        return map;
    }

    const SweepSampling& sampling() const { return sampling_; }
    int frames_ignored() const { return follower_.ignored(); }

  protected:
    struct Row {
        std::vector<Pulse>* pulses;
        const SampleHistogram* effective;
        std::uint32_t saturated_samples;
    };
    virtual void advance_row(int y, int begin, int end) = 0;
    virtual void finish_row(int y) = 0;
    virtual int oldest_needed(int y, int otherwise) const = 0;
    virtual Row row(int y) = 0;

    FrameStore frames_;

  private:
    void analyse() {
        const int begin = analysed_, end = frames_.count();
        for_row_bands(height_, options_.threads, [&](int first, int last) {
            for (int y = first; y < last; ++y) advance_row(y, begin, end);
        });
        analysed_ = end;
        int oldest = end - options_.history_frames;
        for (int y = 0; y < height_; ++y) oldest = oldest_needed(y, oldest);
        frames_.release_before(oldest);
    }

    void close_windows() {
        for_row_bands(height_, options_.threads, [&](int first, int last) {
            for (int y = first; y < last; ++y) {
                finish_row(y);
                tidy_row(*row(y).pulses, options_.max_pulses_per_cell);
            }
        });
    }

    void judge_sampling(PulseMap& map) {
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

    void assemble(PulseMap& map) {
        map.cell_begin.assign(
            static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) + 1, 0);
        if (map.undersampled) return;
        std::size_t cell = 0;
        for (int y = 0; y < height_; ++y) {
            const std::vector<Pulse>& pulses = *row(y).pulses;
            std::size_t i = 0;
            for (int x = 0; x < width_; ++x) {
                for (; i < pulses.size() && static_cast<int>(pulses[i].u) == x; ++i)
                    map.pulses.push_back(pulses[i]);
                map.cell_begin[++cell] = static_cast<std::uint32_t>(map.pulses.size());
            }
        }
        flag_widths(map.pulses, options_.width_ratio);
    }

    int width_, height_, bits_;
    SpacetimeOptions options_;
    SweepProbe probe_;
    SweepSampling sampling_;
    FrameFollower follower_;
    std::uint8_t camera_id_ = 0;
    int analysed_ = 0;
};

template <typename T>
class SpacetimeAnalyser::EngineOf final : public Engine {
  public:
    EngineOf(int width, int height, int bits, const SensorNoise& noise,
             const SpacetimeOptions& options)
        : Engine(width, height, bits, noise, options) {
        rows_.reserve(static_cast<std::size_t>(height));
        for (int y = 0; y < height; ++y)
            rows_.emplace_back(width, y, (1 << bits) - 1, noise, options);
    }

  private:
    void advance_row(int y, int begin, int end) override { rows_[y].advance(frames_, begin, end); }
    void finish_row(int y) override { rows_[y].finish(frames_); }
    int oldest_needed(int y, int otherwise) const override {
        return rows_[y].oldest_needed(otherwise);
    }
    Row row(int y) override {
        return {&rows_[y].pulses, &rows_[y].effective, rows_[y].saturated_samples};
    }

    std::vector<PixelTracker<T>> rows_;
};

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
        engine_ = std::make_unique<EngineOf<std::uint16_t>>(width, height, bits, noise, options);
    else
        engine_ = std::make_unique<EngineOf<std::uint8_t>>(width, height, bits, noise, options);
}

SpacetimeAnalyser::~SpacetimeAnalyser() = default;
SpacetimeAnalyser::SpacetimeAnalyser(SpacetimeAnalyser&&) noexcept = default;
SpacetimeAnalyser& SpacetimeAnalyser::operator=(SpacetimeAnalyser&&) noexcept = default;

void SpacetimeAnalyser::add(const Frame& frame) { engine_->add(frame); }
PulseMap SpacetimeAnalyser::finish() { return engine_->finish(); }
const SweepSampling& SpacetimeAnalyser::sampling() const { return engine_->sampling(); }
int SpacetimeAnalyser::frames_ignored() const { return engine_->frames_ignored(); }

}  // namespace stria

#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/stripe/frame_follower.h"
#include "firmware/stripe/frame_store.h"
#include "firmware/stripe/pixel_window.h"
#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/sweep_probe.h"

namespace stria {

/// What every implementation of the spacetime analysis shares: frames come in, rows are followed in
/// bands, the pulses of all rows become a map.
class SpacetimeEngine {
  public:
    /// How often frames are analysed, and how many are shown to the probe.
    struct Pace {
        int frames_together = 8;   ///< analysed in one go, a multiple of 8
        int probed_at_first = 32;  ///< all of these, then two of `probe_every`
        int probe_every = 32;
    };

    SpacetimeEngine(int width, int height, int bits, const SensorNoise& noise,
                    const SpacetimeOptions& options, const Pace& pace);
    virtual ~SpacetimeEngine() = default;

    void add(const Frame& frame) {
        if (!accept(frame)) return;
        frames_.add(frame);
        analyse_if_due();
    }
    void add(Frame&& frame) {
        if (!accept(frame)) return;
        frames_.add(std::move(frame));
        analyse_if_due();
    }
    std::optional<Frame> take_spare() { return frames_.take_spare(); }
    PulseMap finish();
    const SweepSampling& sampling() const { return sampling_; }
    int frames_ignored() const { return follower_.ignored(); }
    int most_frames() const { return most_frames_; }
    virtual WindowCounts windows() const = 0;

  protected:
    /// What a row's windows were like.
    struct Row {
        const SampleHistogram* effective;
        std::uint32_t saturated_samples;
    };
    /// Called once before the bands of each pass; the store holds the frames before `end`.
    virtual void begin_pass(int /*end*/) {}
    /// Rows [first, last) take the store's frames [begin, end): called for bands in parallel.
    virtual void advance_rows(int first, int last, int begin, int end) = 0;
    /// The sweep is over: closes what is open.
    virtual void finish_rows(int first, int last) = 0;
    /// First frame that an open window may want; `otherwise` if none is open.
    virtual int oldest_needed(int otherwise) const = 0;
    virtual Row row(int y) const = 0;
    /// Widths beyond them are flagged.
    struct WidthLimits {
        float least = 0, most = std::numeric_limits<float>::infinity();

        std::uint16_t flag(float width) const {
            return width < least || width > most ? kPulseWidthOutOfRange : 0;
        }
    };
    /// After finish_rows(): the widths of a row's pulses, in any order; its pulses, by pixel and as
    /// tidy_row() leaves them, with append() and an end_cell() for each pixel.
    virtual void append_widths(int y, std::vector<float>& widths) = 0;
    virtual void append_row(int y, const WidthLimits& limits, PulseMap& map) = 0;

    static void append(const Pulse& pulse, const WidthLimits& limits, PulseMap& map) {
        map.pulses.push_back(pulse);
        map.pulses.back().flags |= limits.flag(pulse.width);
    }
    void end_cell(int x, int y, PulseMap& map) const {
        map.cell_begin[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(x) + 1] =
            static_cast<std::uint32_t>(map.pulses.size());
    }

    /// Orders a row's pulses by pixel, those of a pixel by strength, then time; drops what two
    /// windows found twice, keeps the strongest of a pixel and suspects weak second ones.
    void tidy_row(std::vector<Pulse>& pulses) const;

    FrameStore frames_;
    const int width_, height_, bits_;
    const SpacetimeOptions options_;

  private:
    bool accept(const Frame& frame);
    void analyse_if_due();
    void analyse();
    void judge_sampling(PulseMap& map);
    void assemble(PulseMap& map);

    Pace pace_;
    SweepProbe probe_;
    SweepSampling sampling_;
    FrameFollower follower_;
    std::uint8_t camera_id_ = 0;
    int analysed_ = 0, most_frames_ = 0;
};

}  // namespace stria

#pragma once
#include <cstdint>
#include <optional>

#include "firmware/acquire/acquire.h"
#include "firmware/acquire/path_sweep.h"

namespace stria {

/// What one pass of a sweep brings together: its log, its pulses, its count of lost frames.
class PassRecorder {
  public:
    enum class Place : std::uint8_t { before, within, after };

    /// The plan has passed validate(): where it follows paths, those of its lasers are there.
    PassRecorder(const ScanPlan& plan, const SweepPass& pass, const CameraInfo& camera,
                 const AcquireOptions& options);

    /// The axis begins its sweep now; what was before is the way to its start.
    void begin_sweep(TimeNs now_ns) { begin_ns_ = now_ns; }
    /// Positions in ascending time; those not later than the last one are left out.
    void append_log(const AxisLog& log);
    /// Where the axis was at the middle of the frame, as far as the log so far tells (it may end a
    /// moment before; then its last slope goes on).
    Place place_of(const Frame& frame) const;
    /// True if the last logged position is within a step of the pass's end.
    bool has_reached_end() const;
    /// Labels the frame with laser, power and exposure, hands it over if frames are recorded, and
    /// analyses it if pulses are.
    Status take(Frame& frame, AcquireSink& sink);
    /// Hands over the log, then the pulse map; also after a failure, with the frames so far.
    Status finish(AcquireSink& sink);

    std::uint32_t frames() const { return frames_; }
    std::uint32_t frames_dropped() const { return frames_dropped_; }

  private:
    Status analyse(const Frame& frame);

    const ScanPlan& plan_;
    SweepPass pass_;
    AxisLog log_;
    TimeNs begin_ns_ = 0;
    std::optional<SpatialAnalyser> spatial_;
    std::optional<SpacetimeAnalyser> spacetime_;
    std::optional<PathSweep> along_paths_;
    std::optional<std::uint32_t> last_sequence_;
    std::uint32_t frames_ = 0;
    std::uint32_t frames_dropped_ = 0;
};

/// Adds the samples of `more` that are later than the last of `log`.
void append(AxisLog& log, const AxisLog& more);

}  // namespace stria

#pragma once
#include "firmware/acquire/acquire.h"
#include "firmware/stripe/frame_store.h"

namespace stria {

/// True if the plan asks for pulses in spacetime on a machine that moves the part.
bool follows_paths(const ScanPlan& plan, const AcquireOptions& options);

/// The paths of that laser, or nullptr.
const PathTable* find_paths(const AcquireOptions& options, std::uint8_t laser_id);

/// Pulses along image paths of one pass. A frame waits until the axis log has passed its time, so
/// that its position is what a recording of the sweep tells too. Holds the frames that wait, at
/// most kMostWaiting, besides those of the analyser.
class PathSweep {
  public:
    static constexpr int kMostWaiting = 64;

    PathSweep(const PathTable& table, const CameraInfo& camera, const PathOptions& options)
        : analyser_(table, camera.bits, camera.noise, options) {}

    /// Takes a frame; fails if the log lags too far behind.
    Status add(const Frame& frame, const AxisLog& log);
    /// The pulses of every frame that the log covers. Call once.
    PulseMap finish(const AxisLog& log);

  private:
    void analyse_to(TimeNs end_ns, const AxisLog& log);

    PathAnalyser analyser_;
    FrameStore waiting_;
};

}  // namespace stria

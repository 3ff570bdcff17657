#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/core/pulse.h"
#include "firmware/core/result.h"
#include "firmware/core/scan_plan.h"
#include "firmware/devices/devices.h"
#include "firmware/stripe/path_spacetime.h"
#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"

/// Carries out a scan plan: home, images with the laser off, sweeps with the laser on.
namespace stria {

struct AcquireOptions {
    /// Swept machines only: a pixel is a surface point. Others need image paths for spacetime.
    bool spacetime_per_pixel = true;
    std::vector<PathTable> path_tables;  ///< at most one a laser
    TimeNs exposure_ns = kNsPerMs;       ///< where the plan names none
    TimeNs frame_period_ns = 0;          ///< wanted; longer if camera or axis ask for it
    double max_emission_s = 3600;        ///< cap of the configuration over the plan's own
    SpatialOptions spatial;
    SpacetimeOptions spacetime;
    PathOptions paths;
};

/// Empty if pulses can be followed along this table on these devices, else why not: the machine's
/// pixels are surface points, the camera's size, a laser that it does not have.
std::string check_paths(const PathTable& table, const Devices& devices,
                        const AcquireOptions& options);

/// The tables that a run of the plan follows: one for each of its lasers where it measures pulses
/// in spacetime on a machine that moves the part; else, or where one is missing, none.
std::vector<const PathTable*> paths_followed(const ScanPlan& plan, const AcquireOptions& options);

/// What spacetime analysis follows, for people: pixels, tables, or why there is nothing to follow.
std::string describe_paths(const AcquireOptions& options);

/// One pass of the axis with one laser and one exposure. Its frames are those whose middle lies
/// within from..to.
struct SweepPass {
    double from = 0, to = 0;  ///< from > to on the way back
    std::uint8_t laser_id = 0;
    std::uint8_t exposure_index = 0;
    TimeNs exposure_ns = 0;
    TimeNs frame_period_ns = 0;
    double speed = 0;          ///< unit of s per second
    std::uint32_t frames = 0;  ///< expected, (to - from) / step + 1
};

/// The plan's passes in order: for each laser, for each exposure, there (and back). The camera
/// takes one exposure a pass, so several exposures mean several passes.
std::vector<SweepPass> passes_of(const ScanPlan& plan, const Devices& devices,
                                 const AcquireOptions& options);

/// Empty if these devices can carry out the plan, else field, value and bound: travel, exposures,
/// lasers, mode, emission.
std::string validate(const ScanPlan& plan, const Devices& devices, const AcquireOptions& options);

/// Where a run stands.
struct AcquireStatus {
    std::uint32_t frames = 0;  ///< laser on, within the sweep
    std::uint32_t frames_expected = 0;
    std::uint32_t frames_dropped = 0;  ///< gaps in the sequence during sweeps
    double emission_s = 0;
    bool laser_on = false;
};

/// Takes what a run brings, in order. A failure ends the run. Calls come from the thread of
/// run_plan().
class AcquireSink {
  public:
    virtual ~AcquireSink() = default;
    /// Off frames always; frames of a sweep if the plan records frames.
    virtual Status take_frame(const Frame& frame) = 0;
    /// Positions since the log before.
    virtual Status take_axis_log(const AxisLog& log) = 0;
    /// One a pass, if the plan records pulses; s and ds_dt assigned.
    virtual Status take_pulse_map(const PulseMap& map) = 0;
    /// After every frame; must return at once.
    virtual void take_status(const AcquireStatus& status) = 0;
};

struct AcquireReport {
    bool complete = false;
    std::string reason;  ///< why not
    AcquireStatus status;
};

/// Runs the plan on the calling thread. Whatever happens, the machine is in its safe state when
/// this returns, and a run that could not be finished keeps and hands over what it has: the log and
/// the pulses of the frames so far. Ends early on `stop`, an open interlock, a used-up emission
/// budget, a device or sink that fails, a camera that gives no frame for 3 periods + 1 s, an axis
/// that stops. Does not throw.
AcquireReport run_plan(const ScanPlan& plan, const Devices& devices, const AcquireOptions& options,
                       AcquireSink& sink, const std::atomic<bool>& stop);

}  // namespace stria

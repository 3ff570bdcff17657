#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/core/axis_log.h"
#include "firmware/core/frame.h"
#include "firmware/core/result.h"
#include "firmware/core/sensor_noise.h"
#include "firmware/core/time.h"

/// The machine's parts as the firmware sees them: narrow, blocking, one owner each. The real ones
/// (firmware/linux) and the simulated ones (sim/) pass the same contract tests. No call throws.
namespace stria {

/// The device's monotonic time. The simulated clock moves only when something waits on it.
class Clock {
  public:
    virtual ~Clock() = default;
    virtual TimeNs now() = 0;
    virtual void sleep_until(TimeNs time_ns) = 0;
};

/// Which moment of a frame its kernel time stamp marks.
enum class TimestampPoint : std::uint8_t { exposure_start, readout_start, readout_end };

struct CameraInfo {
    std::string name;
    int width = 0;
    int height = 0;
    int bits = 8;
    SensorNoise noise;
    TimeNs row_time_ns = 0;  ///< 0: global shutter
    TimeNs min_frame_period_ns = 0;
    TimeNs min_exposure_ns = 0;
    TimeNs max_exposure_ns = 0;
    TimestampPoint timestamp_point = TimestampPoint::exposure_start;
    TimeNs timestamp_sigma_ns = 0;  ///< measured, not assumed
};

struct CameraSettings {
    TimeNs exposure_ns = 0;
    TimeNs frame_period_ns = 0;  ///< at least exposure and the camera's minimum
};

class Camera {
  public:
    virtual ~Camera() = default;
    virtual CameraInfo info() const = 0;
    /// Only while stopped. Fails outside the limits of info().
    virtual Status configure(const CameraSettings& settings) = 0;
    virtual Status start() = 0;
    /// Overwrites `frame` with the next one, its memory reused; its exposure_start_ns is already
    /// corrected to the start of row 0's exposure. Fails at the deadline (device clock) and while
    /// stopped.
    virtual Status next_frame(Frame& frame, TimeNs deadline_ns) = 0;
    virtual Status stop() = 0;
};

class Laser {
  public:
    virtual ~Laser() = default;
    /// Always allowed; true darkness within the device's stated time.
    virtual Status off() = 0;
    /// power 0..1, 0 excluded.
    virtual Status on(float power) = 0;
};

struct AxisInfo {
    std::string name;
    double min_s = 0, max_s = 0;  ///< travel, mm or rad
    double max_speed = 0;         ///< per second
    double sigma_s = 0;           ///< of a logged position
};

class Axis {
  public:
    virtual ~Axis() = default;
    virtual AxisInfo info() const = 0;
    virtual Status home() = 0;
    /// Blocks until at rest at s, or fails at the deadline.
    virtual Status move_to(double s, TimeNs deadline_ns) = 0;
    /// Begins to move from `from` to `to` at constant speed (> 0, unit of s per second): the speed
    /// is reached before `from` and held past `to`. Returns at once.
    virtual Status start_sweep(double from, double to, double speed) = 0;
    virtual bool is_moving() = 0;
    /// All positions since home() or the last call.
    virtual AxisLog take_log() = 0;
    /// Stops and takes the drive's power away; always allowed.
    virtual Status stop() = 0;
};

class Interlock {
  public:
    virtual ~Interlock() = default;
    virtual bool is_closed() = 0;
};

/// Borrowed parts of one machine.
struct Devices {
    Clock& clock;
    Camera& camera;
    Laser& laser;
    Axis& axis;
    Interlock& interlock;
    std::vector<Laser*> further_lasers = {};  ///< lasers 1, 2, ... of the plan; laser 0 is `laser`
};

}  // namespace stria

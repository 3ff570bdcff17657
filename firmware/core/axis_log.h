#pragma once
#include <optional>
#include <vector>

#include "firmware/core/time.h"

namespace stria {

/// Where the axis was: s in mm on a rail, rad on a mirror (mechanical) or turntable.
struct AxisSample {
    TimeNs t_ns = 0;
    double s = 0;
};

/// Position and speed at one moment.
struct AxisState {
    double s = 0;
    double ds_dt = 0;    ///< unit of s per second
    double sigma_s = 0;  ///< standard deviation of s, from the log's own sigma
};

/// Time-stamped axis positions of a sweep, in ascending time. Always part of a recording.
struct AxisLog {
    std::vector<AxisSample> samples;
    double sigma_s = 0;  ///< standard deviation of each sample's position
};

/// State at `time_ns`, linear between neighbouring samples; empty outside the log's span or with
/// fewer than two samples. ds_dt is the slope of the segment.
std::optional<AxisState> position_at(const AxisLog& log, TimeNs time_ns);

/// True if times ascend strictly and every position is finite.
bool is_valid(const AxisLog& log);

}  // namespace stria

#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/core/pulse.h"

namespace stria {

enum class RecordWhat : std::uint8_t { pulses = 0, frames = 1, both = 2 };

/// One sweep, as plan.toml states it. Positions are in the unit of s (mm or rad).
struct ScanPlan {
    StripeMode mode = StripeMode::spacetime;
    double from = 0;
    double to = 0;
    double step = 0;                   ///< axis travel from one frame to the next, > 0
    std::vector<double> exposures_us;  ///< empty: the camera's present exposure
    double laser_power = 1.0;          ///< 0..1
    std::vector<std::uint8_t> lasers = {0};
    /// Images with the laser off, taken before the sweep with the axis at rest at positions spread
    /// evenly over from..to (one: at from). They are always sent as frames.
    int off_frames = 0;
    double off_exposure_us = 0;  ///< exposure of those; 0: as the others
    bool both_directions = false;
    RecordWhat record = RecordWhat::pulses;
    double max_emission_s = 60.0;  ///< the laser is off after this, done or not
};

/// Empty if the plan can be carried out as it stands, else the field, its value and its bound.
std::string validate(const ScanPlan& plan);

}  // namespace stria

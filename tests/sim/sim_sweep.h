#pragma once
#include <vector>

#include "firmware/core/frame.h"
#include "sim/simulated_scanner.h"

namespace stria {

/// Frames of one sweep and the true axis position at the middle of each exposure (row 0).
struct SimSweep {
    std::vector<Frame> frames;
    std::vector<double> s;
};

/// Sweeps from..to in steps of `step` with the laser at `power`; exposure as the scene has it.
SimSweep record_sweep(SimulatedScanner& scanner, double from, double to, double step,
                      float power = 1.0F);

/// One frame with the axis at rest at s; power 0: laser off.
Frame record_still(SimulatedScanner& scanner, double s, float power, double exposure_us = 0);

/// examples/scenes/NAME.
std::string example_scene(const std::string& name);

}  // namespace stria

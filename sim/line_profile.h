#pragma once

#include "sim/scene.h"

namespace stria {

/// How the laser's power lies along its line, relative to an even one of the same power.
class LineProfile {
  public:
    LineProfile(const SceneLine& line, double fan_rad);

    /// At fan angle phi (rad): exp(-phi^2 / (2 falloff_rad^2)) (1 + ripple cos(2 pi phi /
    /// ripple_rad)) over its mean within the fan; 1 everywhere for an even line.
    double at(double phi) const { return is_even_ ? 1.0 : shape(phi) / mean_; }

  private:
    double shape(double phi) const;

    SceneLine line_;
    bool is_even_;
    double mean_ = 1;
};

}  // namespace stria

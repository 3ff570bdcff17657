#include "sim/line_profile.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stria {

LineProfile::LineProfile(const SceneLine& line, double fan_rad)
    : line_(line), is_even_(line.ripple == 0 && line.falloff_rad == 0) {
    if (is_even_) return;
    // 32 points a ripple or more: the midpoint rule is then exact to 1e-6 of the mean.
    const int points = std::clamp(static_cast<int>(32 * fan_rad / line.ripple_rad), 4096, 1 << 20);
    double sum = 0;
    for (int i = 0; i < points; ++i) sum += shape(((i + 0.5) / points - 0.5) * fan_rad);
    mean_ = sum / points;
}

double LineProfile::shape(double phi) const {
    double value = 1 + line_.ripple * std::cos(2 * std::numbers::pi * phi / line_.ripple_rad);
    if (line_.falloff_rad > 0)
        value *= std::exp(-phi * phi / (2 * line_.falloff_rad * line_.falloff_rad));
    return value;
}

}  // namespace stria

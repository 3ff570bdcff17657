#include "firmware/stripe/path_samples.h"

#include <array>
#include <cmath>

namespace stria {
namespace {

constexpr double kRestsOn = 0.1;  // weight from which a clipped pixel spoils a sample

std::array<double, 4> cubic_weights(double f) {
    const double f2 = f * f, f3 = f2 * f;
    return {-0.5 * f3 + f2 - 0.5 * f, 1.5 * f3 - 2.5 * f2 + 1, -1.5 * f3 + 2 * f2 + 0.5 * f,
            0.5 * f3 - 0.5 * f2};
}

}  // namespace

InterpolatedSample interpolated_sample(const Frame& frame, double u, double v) {
    const int x = static_cast<int>(u), y = static_cast<int>(v);
    const auto across = cubic_weights(u - x), down = cubic_weights(v - y);
    const int full = frame.full_scale();
    InterpolatedSample sample;
    sample.variance_share = 0;
    int rests_on = 0, clipped = 0;
    for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 4; ++i) {
            const double weight = across[i] * down[j];
            if (weight == 0) continue;
            const int value = frame.sample(x - 1 + i, y - 1 + j);
            sample.value += weight * value;
            sample.variance_share += weight * weight;
            if (std::abs(weight) < kRestsOn) continue;
            ++rests_on;
            clipped += value >= full;
        }
    sample.saturated = clipped == rests_on;
    sample.spoiled = clipped > 0 && clipped < rests_on;
    return sample;
}

}  // namespace stria

#include "firmware/stripe/noise_estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace stria {
namespace {

constexpr int kLevels = 32;         // classes of brightness
constexpr int kDifferences = 2048;  // classes of second differences, the last open
constexpr int kRowsPerFrame = 256;
constexpr std::uint64_t kFewest = 200;  // samples a class needs to say something
constexpr double kNoShotNoise = 1e6;    // e-/DN that stand for "none seen"

/// Absolute second differences along rows, by brightness.
struct Differences {
    std::vector<std::array<std::uint32_t, kDifferences>> counts;
    std::array<double, kLevels> level_sum{};
    std::array<std::uint64_t, kLevels> total{};
    Differences() : counts(kLevels) {}
};

void gather(const Frame& frame, int difference_scale, Differences& out) {
    const int stride = std::max(1, frame.height / kRowsPerFrame);
    const int full = frame.full_scale();
    for (int y = stride / 2; y < frame.height; y += stride) {
        for (int x = 1; x + 1 < frame.width; ++x) {
            const int left = frame.sample(x - 1, y), here = frame.sample(x, y);
            const int right = frame.sample(x + 1, y);
            if (std::max({left, here, right}) >= full) continue;  // clipped: no noise to see
            const double level = (left + here + right) / 3.0;
            const auto row = static_cast<std::size_t>(level * kLevels / (full + 1));
            const int difference = std::abs(left - 2 * here + right) / difference_scale;
            ++out.counts[row][static_cast<std::size_t>(std::min(difference, kDifferences - 1))];
            out.level_sum[row] += level;
            ++out.total[row];
        }
    }
}

/// Median of rounded absolute values, the count within a class taken as even.
double median_of(const std::array<std::uint32_t, kDifferences>& counts, std::uint64_t total) {
    const double half = 0.5 * static_cast<double>(total);
    double below = 0;
    for (int value = 0; value < kDifferences; ++value) {
        const double here = counts[static_cast<std::size_t>(value)];
        if (below + here >= half) {
            const double low = value == 0 ? 0.0 : value - 0.5;
            const double span = value == 0 ? 0.5 : 1.0;  // |0| covers half a class
            return low + span * (half - below) / std::max(here, 1.0);
        }
        below += here;
    }
    return kDifferences;
}

}  // namespace

SensorNoise estimate_noise(std::span<const Frame> frames) {
    SensorNoise noise;
    noise.gain_e_per_dn = kNoShotNoise;
    noise.read_noise_e = 0;
    if (frames.empty()) return noise;
    Differences differences;
    const int difference_scale = std::max(1, (frames[0].full_scale() + 1) / 4096);
    for (const Frame& frame : frames) gather(frame, difference_scale, differences);

    // Weighted line through (level, variance beyond rounding), each class weighing its samples over
    // the square of its variance.
    double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
    for (std::size_t row = 0; row < kLevels; ++row) {
        const std::uint64_t n = differences.total[row];
        if (n < kFewest) continue;
        const double level = differences.level_sum[row] / static_cast<double>(n);
        const double median = median_of(differences.counts[row], n) * difference_scale;
        const double sigma = median <= 0.5 ? 0.0 : 1.4826 * median / std::sqrt(6.0);
        const double variance = std::max(sigma * sigma - 1.0 / 12.0, 0.0);
        const double weight = static_cast<double>(n) / std::pow(sigma * sigma + 1.0 / 12.0, 2);
        w += weight;
        wx += weight * level;
        wy += weight * variance;
        wxx += weight * level * level;
        wxy += weight * level * variance;
    }
    if (w <= 0) return noise;
    const double spread = wxx - wx * wx / w;
    double slope = spread > 1e-9 * w ? (wxy - wx * wy / w) / spread : 0.0;
    double offset = (wy - slope * wx) / w;
    if (slope <= 0) {
        slope = 0;
        offset = wy / w;
    } else if (offset < 0) {
        offset = 0;
        slope = wxx > 0 ? wxy / wxx : 0.0;
    }
    if (slope > 1.0 / kNoShotNoise) noise.gain_e_per_dn = 1.0 / slope;
    noise.read_noise_e = std::sqrt(std::max(offset, 0.0)) * noise.gain_e_per_dn;
    return noise;
}

}  // namespace stria

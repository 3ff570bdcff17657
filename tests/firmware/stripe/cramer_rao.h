#pragma once
#include <array>
#include <cmath>
#include <vector>

#include "firmware/core/sensor_noise.h"

/// The bound that an unbiased estimate of a pulse's position cannot beat, written independently of
/// the code under test: std::erf, central differences, Gauss-Jordan elimination.
namespace stria::test {

struct TruePulse {
    double amplitude = 0, position = 0, width = 0, background = 0;
};

/// Mean signal over [x - h, x + h].
inline double expected_sample(const TruePulse& p, double x, double h) {
    const double root = p.width * std::sqrt(2.0);
    const double integral =
        p.width * std::sqrt(M_PI / 2.0) *
        (std::erf((x + h - p.position) / root) - std::erf((x - h - p.position) / root));
    return p.amplitude * integral / (2.0 * h) + p.background;
}

/// Square root of [F^-1] for the position, F = sum of J'J / v over the samples with expectation
/// below `saturation_level`; a clipped sample carries d^2 log-likelihood of its being clipped.
inline double cramer_rao_bound(const TruePulse& truth, const std::vector<double>& x, double h,
                               const SensorNoise& noise, double saturation_level = 1e300) {
    std::array<std::array<double, 8>, 4> m{};
    for (const double at : x) {
        std::array<double, 4> slope{};
        for (int k = 0; k < 4; ++k) {
            TruePulse up = truth, down = truth;
            const double step = 1e-5 * (k == 1 || k == 2 ? truth.width : truth.amplitude);
            double* const high[] = {&up.amplitude, &up.position, &up.width, &up.background};
            double* const low[] = {&down.amplitude, &down.position, &down.width, &down.background};
            *high[k] += step;
            *low[k] -= step;
            slope[k] = (expected_sample(up, at, h) - expected_sample(down, at, h)) / (2.0 * step);
        }
        const double mean = expected_sample(truth, at, h);
        const double variance = sample_variance(noise, mean);
        // Information about the mean in min(y, level), y normal: (phi^2 / Q + P(y < level) -
        // z phi) / v with z = (level - mean) / s; 1 / v when the level is far.
        double information = 1.0 / variance;
        const double z = (saturation_level - mean) / std::sqrt(variance);
        if (z < 8.0) {
            const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * M_PI);
            const double above = 0.5 * std::erfc(z / std::sqrt(2.0));
            const double hazard = above > 1e-300 ? density * density / above : 0.0;
            information = (hazard + (1.0 - above) - z * density) / variance;
        }
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b) m[a][b] += slope[a] * slope[b] * information;
    }
    for (int a = 0; a < 4; ++a) m[a][4 + a] = 1.0;
    for (int pivot = 0; pivot < 4; ++pivot) {
        const double scale = 1.0 / m[pivot][pivot];
        for (double& value : m[pivot]) value *= scale;
        for (int row = 0; row < 4; ++row) {
            if (row == pivot) continue;
            const double factor = m[row][pivot];
            for (int k = 0; k < 8; ++k) m[row][k] -= factor * m[pivot][k];
        }
    }
    return std::sqrt(m[1][5]);
}

}  // namespace stria::test

#include "firmware/stripe/peak_window.h"

#include <algorithm>
#include <cmath>

#include "firmware/stripe/gaussian_integral.h"

namespace stria {
namespace {

constexpr int kSideSamples = 4;

/// Light of the fit's peak k in pixel x, DN.
double light_of(const GaussianFit& fit, int k, int x) {
    const double low = (x - 0.5 - fit.position[k]) / fit.width;
    const double high = (x + 0.5 - fit.position[k]) / fit.width;
    return fit.amplitude[k] * fit.width * kSqrtTwoPi *
           (normal_terms(high).cumulative - normal_terms(low).cumulative);
}

/// Takes the mean of the outermost samples of both sides from all of them.
void subtract_background(PeakWindow& window) {
    double sum = 0, variance = 0;
    for (int t = window.half - kSideSamples + 1; t <= window.half; ++t) {
        sum += window.at(t) + window.at(-t);
        variance += window.variance(t) + window.variance(-t);
    }
    constexpr double kCount = 2.0 * kSideSamples;
    window.background_variance = variance / (kCount * kCount);
    const auto count = static_cast<std::size_t>(2 * window.half + 1);
    for (std::size_t i = 0; i < count; ++i) window.samples[i] -= sum / kCount;
}

}  // namespace

std::optional<PeakWindow> peak_window(std::span<const float> row, const SensorNoise& noise,
                                      double full_scale, const GaussianFit& fit, int k) {
    PeakWindow window;
    window.centre = static_cast<int>(std::lround(fit.position[k]));
    window.width = fit.width;
    window.blurred_width = std::sqrt(fit.width * fit.width + 1.0 / 12.0);
    window.half = static_cast<int>(std::ceil(4.0 * window.blurred_width)) + kSideSamples - 1;
    const int first = window.centre - window.half, last = window.centre + window.half;
    if (window.half > kMaxWindowHalf || first < 0 || last >= static_cast<int>(row.size()))
        return std::nullopt;
    for (int x = first; x <= last; ++x) {
        const double value = row[static_cast<std::size_t>(x)];
        const auto i = static_cast<std::size_t>(x - first);
        window.variances[i] =
            value >= full_scale ? 0.0 : sample_variance(noise, std::max(value, fit.background));
        window.samples[i] = fit.peaks > 1 ? value - light_of(fit, 1 - k, x) : value;
    }
    subtract_background(window);
    return window;
}

}  // namespace stria

#include "sim/stripe_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stria {
namespace {

constexpr double kDarkBeyond = 5.5;  ///< standard deviations; the rest is 4e-8 of the light
constexpr std::size_t kMostBins = 256;

}  // namespace

double mean_gaussian(double x0, double x1) {
    const double width = std::abs(x1 - x0), middle = (x0 + x1) / 2;
    if (width < 0.05) {  // two terms of the series; the next is width^4 / 1920
        const double m2 = middle * middle;
        return std::exp(-m2 / 2) * (1 + width * width / 24 * (m2 - 1));
    }
    const double half = std::numbers::sqrt2 / 2;
    return std::sqrt(std::numbers::pi / 2) * std::abs(std::erf(x1 * half) - std::erf(x0 * half)) /
           width;
}

void sort_into_bins(LightBlock& block) {
    const std::vector<StripeLight>& lights = block.lights;
    block.reach = 0;
    block.bin_begin = {0, static_cast<std::uint32_t>(lights.size())};
    block.first_bin_s = 0;
    block.bin_width = 0;
    if (lights.empty()) return;
    double low = lights[0].s0, high = low;
    for (const StripeLight& light : lights) {
        low = std::min(low, light.s0);
        high = std::max(high, light.s0);
        block.reach = std::max(block.reach, kDarkBeyond / static_cast<double>(light.per_s));
    }
    block.first_bin_s = low;
    const std::size_t bins = std::min(kMostBins, lights.size() / 32 + 1);
    block.bin_width = (high - low) / static_cast<double>(bins);
    const auto bin_of = [&](const StripeLight& light) {
        if (!(block.bin_width > 0)) return std::size_t{0};
        return std::min(bins - 1, static_cast<std::size_t>((light.s0 - low) / block.bin_width));
    };
    std::vector<std::uint32_t> begin(bins + 1, 0);
    for (const StripeLight& light : lights) ++begin[bin_of(light) + 1];
    for (std::size_t i = 0; i < bins; ++i) begin[i + 1] += begin[i];
    std::vector<StripeLight> sorted(lights.size());
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (const StripeLight& light : lights) sorted[next[bin_of(light)]++] = light;
    block.lights = std::move(sorted);
    block.bin_begin = std::move(begin);
}

void add_stripe(const LightBlock& block, int width, std::span<const Exposure> exposures,
                int row_count, std::span<float> electrons) {
    if (block.lights.empty() || exposures.empty()) return;
    double low = exposures[0].s_begin, high = low;
    for (const Exposure& exposure : exposures) {
        low = std::min({low, exposure.s_begin, exposure.s_end});
        high = std::max({high, exposure.s_begin, exposure.s_end});
    }
    const std::size_t bins = block.bin_begin.size() - 1;
    std::size_t first = 0, last = bins;
    if (block.bin_width > 0) {
        const auto bin_at = [&](double s) {
            const double at = std::floor((s - block.first_bin_s) / block.bin_width);
            return static_cast<std::ptrdiff_t>(std::clamp(at, -1.0, static_cast<double>(bins)));
        };
        first = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, bin_at(low - block.reach)));
        last = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
            bin_at(high + block.reach) + 1, 0, static_cast<std::ptrdiff_t>(bins)));
        if (first >= last) return;
    }
    const std::size_t each =
        row_count > 0 ? exposures.size() / static_cast<std::size_t>(row_count) : exposures.size();
    for (std::size_t i = block.bin_begin[first]; i < block.bin_begin[last]; ++i) {
        const StripeLight& light = block.lights[i];
        const std::size_t row = light.pixel / static_cast<std::uint32_t>(width);
        const Exposure* exposure = exposures.data() + (row_count > 0 ? row * each : 0);
        double sum = 0;
        for (std::size_t e = 0; e < each; ++e, ++exposure) {
            const double x0 = (exposure->s_begin - light.s0) * static_cast<double>(light.per_s);
            const double x1 = (exposure->s_end - light.s0) * static_cast<double>(light.per_s);
            if (std::min(x0, x1) > kDarkBeyond || std::max(x0, x1) < -kDarkBeyond) continue;
            sum += exposure->seconds_at_power_1 * mean_gaussian(x0, x1);
        }
        electrons[light.pixel] += light.rate * static_cast<float>(sum);
    }
}

}  // namespace stria

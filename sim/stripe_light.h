#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace stria {

/// Laser light of one surface sample in one pixel as a function of the axis position: electrons a
/// second at power 1 are rate * exp(-((s - s0) per_s)^2 / 2).
struct StripeLight {
    double s0 = 0;
    float per_s = 0;          ///< > 0
    float rate = 0;           ///< the sample's share of the pixel included
    std::uint32_t pixel = 0;  ///< within its block
};

/// A stretch of time in which the axis moves steadily from s_begin to s_end and the laser shines.
struct Exposure {
    double s_begin = 0, s_end = 0;
    double seconds_at_power_1 = 0;  ///< duration times laser power
};

/// What a band of image rows receives.
struct LightBlock {
    int row_begin = 0, row_end = 0;
    std::vector<float> ambient;            ///< electrons a second, one a pixel
    std::vector<std::uint16_t> spots;      ///< SpotSpread's index, one a pixel; empty: all sharp
    std::vector<StripeLight> lights;       ///< in bins of s0
    std::vector<std::uint32_t> bin_begin;  ///< one more than bins
    double first_bin_s = 0, bin_width = 0;
    double reach = 0;  ///< of the widest light, beyond which it is dark (5.5 sigma)
};

/// Mean of exp(-x^2 / 2) over [x0, x1] (either order).
double mean_gaussian(double x0, double x1);

/// Puts the lights in bins of s0, keeping their order within a bin; sets bins and reach.
void sort_into_bins(LightBlock& block);

/// Adds to `electrons` (one a pixel of the block) what the stripe gives. `exposures` are those of
/// the whole block, or with `row_count` > 0, row after row, each `exposures.size() / row_count`.
void add_stripe(const LightBlock& block, int width, std::span<const Exposure> exposures,
                int row_count, std::span<float> electrons);

}  // namespace stria

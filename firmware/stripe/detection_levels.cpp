#include "firmware/stripe/detection_levels.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

constexpr double kDetectionShare = 0.7;  // of min_snr: one sample may lie below the pulse's height
/// The expected second least of n normal samples is that many standard deviations below their mean.
constexpr std::array<double, 9> kExpectedSecond = {0, 0, 0, 0, 0.30, 0.50, 0.64, 0.76, 0.85};

}  // namespace

DetectionLevels::DetectionLevels(int bits, const SensorNoise& noise, double min_snr,
                                 double min_amplitude_dn)
    : shift_(bits + 4), highest_((1u << (bits + 8)) - 1u), noise_(noise) {
    const double share = std::max(kDetectionShare * min_snr, 3.5);
    const auto at = [&](int segment) {
        const double dn = std::ldexp(segment, bits - 4);
        const double wanted =
            std::max(share * std::sqrt(sample_variance(noise, dn)), 0.5 * min_amplitude_dn);
        return static_cast<std::uint32_t>(std::min(256.0 * wanted + 0.5, double(highest_)));
    };
    for (int s = 0; s < kSegments; ++s) {
        base_[static_cast<std::size_t>(s)] = at(s);
        rise_[static_cast<std::size_t>(s)] = at(s + 1) - at(s);
    }
}

std::uint32_t DetectionLevels::first(const FirstSamples& samples) const {
    const std::uint32_t still = margin(samples.second << 8) + margin(samples.second << 8) / 2;
    if (((samples.greatest - samples.second) << 8) <= still)
        return static_cast<std::uint32_t>((std::uint64_t{samples.sum} << 8) /
                                          static_cast<std::uint32_t>(samples.count));
    const double raise =
        kExpectedSecond[std::min<std::size_t>(static_cast<std::size_t>(samples.count), 8)];
    const double level =
        samples.second + raise * std::sqrt(sample_variance(noise_, samples.second));
    return static_cast<std::uint32_t>(
        std::min(256.0 * level + 0.5, double(highest_ & ~std::uint32_t{255})));
}

std::uint32_t DetectionLevels::follow(std::uint32_t background, std::uint32_t sum,
                                      int count) const {
    const auto mean =
        static_cast<std::uint32_t>((std::uint64_t{sum} << 8) / static_cast<std::uint32_t>(count));
    const std::uint32_t level = threshold(background) << 8;
    const std::uint32_t room = level > background ? level - background : 0;
    if (mean >= background) return background + (std::min(mean - background, room) >> 2);
    const std::uint32_t down = background - mean;
    return down > room ? mean : background - (down >> 2);
}

}  // namespace stria

#pragma once
#include <array>
#include <cstdint>

#include "firmware/core/sensor_noise.h"

namespace stria {

/// Follows the background of a pixel and says what counts as light above it, in fixed point: levels
/// are 1/256 DN. Integers throughout, so that every implementation has the same levels.
class DetectionLevels {
  public:
    static constexpr int kSegments = 16;

    /// @param bits  of a sample, 8..16
    DetectionLevels(int bits, const SensorNoise& noise, double min_snr, double min_amplitude_dn);

    /// What a sample must exceed the background by: the detection's share of min_snr times the
    /// noise, but half of min_amplitude_dn; between 16 levels interpolated linearly.
    std::uint32_t margin(std::uint32_t background) const {
        const std::uint32_t segment = background >> shift_;
        const std::uint32_t part = fraction(background);
        return base_[segment] +
               static_cast<std::uint32_t>((std::uint64_t{part} * rise_[segment]) >> 16);
    }
    /// Samples (DN) above it are light.
    std::uint32_t threshold(std::uint32_t background) const {
        const std::uint32_t level = background + margin(background);
        return (level < highest_ ? level : highest_) >> 8;
    }
    /// A pixel's first samples, DN. Of their least the second one counts, so that a single outlier
    /// does no harm.
    struct FirstSamples {
        std::uint32_t least, second, greatest, sum;
        int count = 1;

        explicit FirstSamples(std::uint32_t sample)
            : least(sample), second(sample), greatest(sample), sum(sample) {}
        void add(std::uint32_t sample) {
            const std::uint32_t larger = sample > least ? sample : least;
            second = count == 1 || larger < second ? larger : second;
            least = sample < least ? sample : least;
            greatest = sample > greatest ? sample : greatest;
            sum += sample;
            ++count;
        }
    };
    /// From them: their mean, where they differ by no more than 1.5 margins; else the light has
    /// moved, and it is the second least, raised by what noise lowers that.
    std::uint32_t first(const FirstSamples& samples) const;
    /// The background after `count` samples whose sum is `sum` (DN): a quarter of the way towards
    /// their mean, by at most a quarter of the margin upwards; all the way where it has fallen by
    /// more than the margin.
    std::uint32_t follow(std::uint32_t background, std::uint32_t sum, int count) const;

    /// margin()'s table: at the beginning of a segment, and from there to the next one's.
    const std::array<std::uint32_t, kSegments>& base() const { return base_; }
    const std::array<std::uint32_t, kSegments>& rise() const { return rise_; }

  private:
    std::uint32_t fraction(std::uint32_t background) const {  // of a segment, in 1/65536
        return shift_ < 16 ? (background << (16 - shift_)) & 0xffffu
                           : (background >> (shift_ - 16)) & 0xffffu;
    }

    int shift_;
    std::uint32_t highest_;
    SensorNoise noise_;
    std::array<std::uint32_t, kSegments> base_{}, rise_{};
};

}  // namespace stria

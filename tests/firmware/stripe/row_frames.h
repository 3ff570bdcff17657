#pragma once
#include <vector>

#include "tests/firmware/stripe/localisation.h"

namespace stria::test {

/// A frame of the given size whose rows show these pulses; additive noise of `noise`.
inline Frame frame_of(int width, int height, int bits, const std::vector<TruePulse>& pulses,
                      const SensorNoise& noise, unsigned seed) {
    Frame frame;
    resize(frame, width, height, bits);
    frame.row_time_ns = 1000;
    frame.exposure_ns = 2'000'000;
    std::mt19937_64 rng(seed);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            double mean = 0;
            for (const TruePulse& p : pulses) mean += expected_sample(p, x, 0.5);
            set_sample(frame, x, y, noisy_sample(mean, noise, frame.full_scale(), rng));
        }
    }
    return frame;
}

constexpr SensorNoise kSilent = {.gain_e_per_dn = 1e9, .read_noise_e = 0};

}  // namespace stria::test

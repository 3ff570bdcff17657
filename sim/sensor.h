#pragma once
#include <cstdint>
#include <span>

#include "sim/scene.h"

namespace stria {

/// What decides the random numbers of one frame; pixels count within it.
struct NoiseKey {
    std::uint32_t first = 0, second = 0;
};
NoiseKey noise_key(std::uint64_t seed, int view, std::int64_t frame);

/// Digital numbers of pixels whose expected electrons are given: shot noise (Poisson; above 30
/// electrons its normal approximation), full well, read noise, gain, black level, rounding and
/// clipping (EMVA 1288 linear model). `dn` receives one byte a pixel, or two (native order) where
/// the sensor has more than 8 bits.
/// @param first_pixel  index in the frame of the first one: same numbers however a frame is cut
/// @param offset_e     of the pixels, electrons, added after all noise; empty: none
/// With an offset or a gamma other than 1 the signal is converted to 1/64 DN first, then comes the
/// response curve, then rounding and clipping.
void digitise(const SceneSensor& sensor, NoiseKey key, std::uint32_t first_pixel,
              std::span<const float> electrons, std::uint8_t* dn,
              std::span<const float> offset_e = {});

/// The portable version of digitise, which its vector versions must equal to the bit.
void digitise_portably(const SceneSensor& sensor, NoiseKey key, std::uint32_t first_pixel,
                       std::span<const float> electrons, std::uint8_t* dn,
                       std::span<const float> offset_e = {});

}  // namespace stria

#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>

/// Random numbers as functions of what they belong to, not of the order in which they are drawn: so
/// that threads cannot change them.
namespace stria::counter_random {

/// Mixes 32 bits (C. Wellons' lowbias32). Vectorises.
inline std::uint32_t mix32(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

/// Mixes 64 bits (SplitMix64's finaliser).
inline std::uint64_t mix64(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return x ^ (x >> 31);
}

/// 64 bits that belong to (seed, stream, counter).
inline std::uint64_t bits(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
    return mix64(mix64(mix64(seed) ^ stream) ^ counter);
}

/// Uniform in (0, 1).
inline double uniform(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
    return (static_cast<double>(bits(seed, stream, counter) >> 11) + 0.5) * 0x1p-53;
}

/// Standard normal (Box and Muller 1958).
inline double normal(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
    const double u = uniform(seed, stream, 2 * counter);
    const double v = uniform(seed, stream, 2 * counter + 1);
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}

/// What the streams of one seed are for.
enum Stream : std::uint64_t {
    kPixelNoise = 1,
    kAxisLog,
    kDroppedFrames,
    kFrameJitter,
    kNominal,
    kPixelGain,
    kPixelDark,
    kDuplicatedFrames,
    kSpeckle,
    kSurfaceSpeckle,
    kScreenSpeckle,
    kAxisWobble
};

}  // namespace stria::counter_random

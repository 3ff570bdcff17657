#include "sim/sensor.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "sim/random.h"

// Compiled without contraction of a * b + c, so that every instruction set gives the same bits.
#if defined(__x86_64__)
#define STRIA_X86 1
#endif

namespace stria {
namespace {

constexpr float kPoissonBelow = 30.0F;  ///< electrons; above it the normal approximation serves
constexpr std::size_t kRun = 256;       ///< pixels a pass, so that buffers stay in the first cache

/// The sensor's numbers as the inner loop wants them.
struct Converter {
    float full_well = 0, read_noise = 0, dn_per_e = 0, black_plus_half = 0, top_dn = 0;
};

inline __attribute__((always_inline)) std::uint32_t pixel_bits(NoiseKey key, std::uint32_t pixel) {
    return counter_random::mix32(counter_random::mix32(pixel + key.first) ^ key.second);
}

/// ln x for normal x > 0, absolute error below 2e-7 near 1, relative below 1e-6 elsewhere.
inline __attribute__((always_inline)) float fast_log(float x) {
    const auto raw = std::bit_cast<std::int32_t>(x);
    const std::int32_t shifted = (raw - 0x3f3504f3) >> 23;  // mantissa into [sqrt(1/2), sqrt(2))
    const float m = std::bit_cast<float>(raw - (shifted << 23)) - 1.0F;
    float p = 7.0376836292e-2F;  // Cephes logf
    p = p * m - 1.1514610310e-1F;
    p = p * m + 1.1676998740e-1F;
    p = p * m - 1.2420140846e-1F;
    p = p * m + 1.4249322787e-1F;
    p = p * m - 1.6668057665e-1F;
    p = p * m + 2.0000714765e-1F;
    p = p * m - 2.4999993993e-1F;
    p = p * m + 3.3333331174e-1F;
    const float m2 = m * m;
    return m * m2 * p - 0.5F * m2 + m + 0.69314718F * static_cast<float>(shifted);
}

inline __attribute__((always_inline)) float uniform_from_bits(std::uint32_t random) {
    return (static_cast<float>(static_cast<std::int32_t>(random >> 9)) + 0.5F) * 0x1p-22F - 1.0F;
}

/// Standard normal from a uniform number u in (-1, 1) by the inverse error function; M. Giles,
/// "Approximating the erfinv function", GPU Computing Gems 2, 2011, single precision: the central
/// part, and the tails where w = -ln(1 - u^2) >= 5.
inline __attribute__((always_inline)) float central_normal(float u, float w) {
    const float a = w - 2.5F;
    float p = 2.81022636e-08F;
    p = 3.43273939e-07F + p * a;
    p = -3.5233877e-06F + p * a;
    p = -4.39150654e-06F + p * a;
    p = 0.00021858087F + p * a;
    p = -0.00125372503F + p * a;
    p = -0.00417768164F + p * a;
    p = 0.246640727F + p * a;
    p = 1.50140941F + p * a;
    return 1.41421356F * u * p;
}

inline __attribute__((always_inline)) float tail_normal(float u, float w) {
    const float b = std::sqrt(w) - 3.0F;
    float q = -0.000200214257F;
    q = 0.000100950558F + q * b;
    q = 0.00134934322F + q * b;
    q = -0.00367342844F + q * b;
    q = 0.00573950773F + q * b;
    q = -0.0076224613F + q * b;
    q = 0.00943887047F + q * b;
    q = 1.00167406F + q * b;
    q = 2.83297682F + q * b;
    return 1.41421356F * u * q;
}

float normal_from_bits(std::uint32_t random) {
    const float u = uniform_from_bits(random);
    const float w = -fast_log((1.0F - u) * (1.0F + u));
    return w < 5.0F ? central_normal(u, w) : tail_normal(u, w);
}

inline __attribute__((always_inline)) float clipped_dn(const Converter& c, float electrons) {
    const float dn = electrons * c.dn_per_e + c.black_plus_half;
    return dn < 0.0F ? 0.0F : dn > c.top_dn ? c.top_dn : dn;
}

/// Loops without a branch, which the compiler turns into vectors; the tails in a pass of their own,
/// one pixel in 150.
inline __attribute__((always_inline)) void noisy_run(const Converter& c, NoiseKey key,
                                                     std::uint32_t first, const float* electrons,
                                                     std::int32_t* dn, std::size_t count) {
    float u[kRun], w[kRun], z[kRun];
    for (std::size_t i = 0; i < count; ++i) {
        u[i] = uniform_from_bits(pixel_bits(key, first + static_cast<std::uint32_t>(i)));
        w[i] = -fast_log((1.0F - u[i]) * (1.0F + u[i]));
        z[i] = central_normal(u[i], w[i]);
    }
    for (std::size_t i = 0; i < count; ++i)
        if (!(w[i] < 5.0F)) z[i] = tail_normal(u[i], w[i]);
    const float read2 = c.read_noise * c.read_noise;
    for (std::size_t i = 0; i < count; ++i) {
        const float sum = electrons[i] + std::sqrt(electrons[i] + read2) * z[i];
        const float full = c.full_well + c.read_noise * z[i];
        dn[i] = static_cast<std::int32_t>(clipped_dn(c, sum < full ? sum : full));
    }
}

using NoisyRun = void (*)(const Converter&, NoiseKey, std::uint32_t, const float*, std::int32_t*,
                          std::size_t);

void noisy_portable(const Converter& c, NoiseKey key, std::uint32_t first, const float* electrons,
                    std::int32_t* dn, std::size_t count) {
    noisy_run(c, key, first, electrons, dn, count);
}

#ifdef STRIA_X86
__attribute__((target("avx2"))) void noisy_avx2(const Converter& c, NoiseKey key,
                                                std::uint32_t first, const float* electrons,
                                                std::int32_t* dn, std::size_t count) {
    noisy_run(c, key, first, electrons, dn, count);
}

__attribute__((target("avx512f,avx512dq,avx512bw,avx512vl,prefer-vector-width=512"))) void
noisy_avx512(const Converter& c, NoiseKey key, std::uint32_t first, const float* electrons,
             std::int32_t* dn, std::size_t count) {
    noisy_run(c, key, first, electrons, dn, count);
}
#endif

NoisyRun best_noisy_run() {
#ifdef STRIA_X86
    __builtin_cpu_init();
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
        return noisy_avx512;
    if (__builtin_cpu_supports("avx2")) return noisy_avx2;
#endif
    return noisy_portable;
}

/// Poisson number of mean `mean` by inversion: the first n whose cumulated probability exceeds the
/// uniform number.
int poisson(double mean, double uniform) {
    double term = std::exp(-mean), sum = term;
    int n = 0;
    while (uniform > sum && n < 200) {
        term *= mean / ++n;
        sum += term;
    }
    return n;
}

/// Does the few dim pixels of a run over again with the true distribution.
void redo_dim_pixels(const Converter& c, NoiseKey key, std::uint32_t first, const float* electrons,
                     std::int32_t* dn, std::size_t count) {
    const NoiseKey other{key.first ^ 0x5bd1e995u, key.second + 0x1b873593u};
    for (std::size_t i = 0; i < count; ++i) {
        if (!(electrons[i] > 0.0F && electrons[i] < kPoissonBelow)) continue;
        const std::uint32_t pixel = first + static_cast<std::uint32_t>(i);
        const double uniform = (static_cast<double>(pixel_bits(other, pixel)) + 0.5) * 0x1p-32;
        const auto shot = static_cast<float>(poisson(static_cast<double>(electrons[i]), uniform));
        const float z = normal_from_bits(pixel_bits(key, pixel));
        dn[i] = static_cast<std::int32_t>(
            clipped_dn(c, std::min(shot, c.full_well) + c.read_noise * z));
    }
}

std::size_t dim_pixels(const float* electrons, std::size_t count) {
    std::int32_t dim = 0;
    for (std::size_t i = 0; i < count; ++i)
        dim += static_cast<std::int32_t>(electrons[i] > 0.0F) &
               static_cast<std::int32_t>(electrons[i] < kPoissonBelow);
    return static_cast<std::size_t>(dim);
}

void exact_run(const Converter& c, const float* electrons, std::int32_t* dn, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        dn[i] = static_cast<std::int32_t>(clipped_dn(c, std::min(electrons[i], c.full_well)));
}

void store(const std::int32_t* dn, std::size_t count, bool wide, std::uint8_t* out) {
    if (!wide) {
        for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<std::uint8_t>(dn[i]);
        return;
    }
    std::uint16_t samples[kRun];
    for (std::size_t i = 0; i < count; ++i) samples[i] = static_cast<std::uint16_t>(dn[i]);
    std::memcpy(out, samples, count * sizeof(std::uint16_t));
}

constexpr int kFine = 64;  ///< steps a DN before the response curve

Converter plain_converter(const SceneSensor& sensor) {
    return {.full_well = static_cast<float>(sensor.full_well_e),
            .read_noise = static_cast<float>(sensor.read_noise_e),
            .dn_per_e = static_cast<float>(1.0 / sensor.gain_e_per_dn),
            .black_plus_half = static_cast<float>(sensor.black_dn + 0.5),
            .top_dn = static_cast<float>((1 << sensor.bits) - 1)};
}

/// Fine steps above a pedestal, so that offsets and noise below black are not cut off yet.
int pedestal_dn(const SceneSensor& sensor) { return 1 << sensor.bits; }

Converter fine_converter(const SceneSensor& sensor) {
    Converter c = plain_converter(sensor);
    c.dn_per_e *= kFine;
    c.black_plus_half = static_cast<float>((sensor.black_dn + pedestal_dn(sensor)) * kFine + 0.5);
    c.top_dn = static_cast<float>(4 * pedestal_dn(sensor) * kFine);
    return c;
}

/// Offsets, response curve, rounding and clipping of fine steps, in place.
void finish_fine(const SceneSensor& sensor, std::span<const float> offset_e, std::int32_t* dn,
                 std::size_t count) {
    const double top = (1 << sensor.bits) - 1, black = sensor.black_dn;
    for (std::size_t i = 0; i < count; ++i) {
        double value = static_cast<double>(dn[i]) / kFine - pedestal_dn(sensor);
        if (!offset_e.empty()) value += static_cast<double>(offset_e[i]) / sensor.gain_e_per_dn;
        if (sensor.gamma != 1 && value > black)
            value = black + (top - black) * std::pow((value - black) / (top - black), sensor.gamma);
        dn[i] = static_cast<std::int32_t>(std::clamp(std::floor(value + 0.5), 0.0, top));
    }
}

void digitise_with(NoisyRun noisy, const SceneSensor& sensor, NoiseKey key,
                   std::uint32_t first_pixel, std::span<const float> electrons, std::uint8_t* out,
                   std::span<const float> offset_e) {
    const bool fine = !offset_e.empty() || sensor.gamma != 1;
    const Converter c = fine ? fine_converter(sensor) : plain_converter(sensor);
    const bool wide = sensor.bits > 8;
    std::int32_t dn[kRun];
    for (std::size_t begin = 0; begin < electrons.size(); begin += kRun) {
        const std::size_t count = std::min(kRun, electrons.size() - begin);
        const float* light = electrons.data() + begin;
        const std::uint32_t first = first_pixel + static_cast<std::uint32_t>(begin);
        if (sensor.noise) {
            noisy(c, key, first, light, dn, count);
            if (dim_pixels(light, count) > 0) redo_dim_pixels(c, key, first, light, dn, count);
        } else {
            exact_run(c, light, dn, count);
        }
        if (fine)
            finish_fine(sensor, offset_e.empty() ? offset_e : offset_e.subspan(begin, count), dn,
                        count);
        store(dn, count, wide, out + begin * (wide ? 2 : 1));
    }
}

}  // namespace

NoiseKey noise_key(std::uint64_t seed, int view, std::int64_t frame) {
    const std::uint64_t bits = counter_random::bits(
        seed, counter_random::kPixelNoise + (static_cast<std::uint64_t>(view) << 8),
        static_cast<std::uint64_t>(frame));
    return {static_cast<std::uint32_t>(bits), static_cast<std::uint32_t>(bits >> 32)};
}

void digitise(const SceneSensor& sensor, NoiseKey key, std::uint32_t first_pixel,
              std::span<const float> electrons, std::uint8_t* dn, std::span<const float> offset_e) {
    static const NoisyRun kBest = best_noisy_run();
    digitise_with(kBest, sensor, key, first_pixel, electrons, dn, offset_e);
}

void digitise_portably(const SceneSensor& sensor, NoiseKey key, std::uint32_t first_pixel,
                       std::span<const float> electrons, std::uint8_t* dn,
                       std::span<const float> offset_e) {
    digitise_with(noisy_portable, sensor, key, first_pixel, electrons, dn, offset_e);
}

}  // namespace stria

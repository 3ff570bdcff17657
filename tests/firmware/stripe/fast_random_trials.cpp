#include "tests/firmware/stripe/fast_random_trials.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <utility>

#include "tests/firmware/stripe/byte_sweep.h"

namespace stria::test {
namespace {

constexpr std::uint64_t kAdditiveEvery = 3;  // sweeps

/// The sweep as of a sensor whose noise does not grow with the light: the kernels fit it otherwise.
ByteSweep with_additive_noise(ByteSweep sweep) {
    constexpr double kManyElectrons = 1e6;
    const double read_noise_dn = sweep.noise.read_noise_e / sweep.noise.gain_e_per_dn;
    sweep.noise.gain_e_per_dn = kManyElectrons;
    sweep.noise.read_noise_e = kManyElectrons * read_noise_dn;
    return sweep;
}

ByteSweep random_sweep(std::uint64_t seed) {
    const auto bytes = random_sweep_bytes(seed);
    ByteSweep sweep = sweep_from_bytes(bytes.data(), bytes.size());
    return seed % kAdditiveEvery == 0 ? with_additive_noise(std::move(sweep)) : sweep;
}

}  // namespace

void expect_no_broken_bound(std::uint64_t begin, std::uint64_t end) {
    std::size_t pulses = 0;
    for (std::uint64_t seed = begin; seed < end; ++seed)
        for (const Disagreement& one : disagreements(random_sweep(seed), &pulses))
            ADD_FAILURE() << "seed " << seed << ": " << text_of(one);
    std::printf("%llu sweeps, %zu pulses of the reference\n",
                static_cast<unsigned long long>(end - begin), pulses);
    EXPECT_GT(pulses, 5 * (end - begin));  // the sweeps have something to compare
}

}  // namespace stria::test

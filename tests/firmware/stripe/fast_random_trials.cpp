#include "tests/firmware/stripe/fast_random_trials.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/firmware/stripe/byte_sweep.h"

namespace stria::test {

void expect_no_broken_bound(std::uint64_t begin, std::uint64_t end) {
    std::size_t pulses = 0;
    for (std::uint64_t seed = begin; seed < end; ++seed) {
        const auto bytes = random_sweep_bytes(seed);
        for (const Disagreement& one :
             disagreements(sweep_from_bytes(bytes.data(), bytes.size()), &pulses))
            ADD_FAILURE() << "seed " << seed << ": " << text_of(one);
    }
    std::printf("%llu sweeps, %zu pulses of the reference\n",
                static_cast<unsigned long long>(end - begin), pulses);
    EXPECT_GT(pulses, 5 * (end - begin));  // the sweeps have something to compare
}

}  // namespace stria::test

#include "firmware/stripe/fast_spacetime.h"

#include <gtest/gtest.h>

#include <cstring>

#include "firmware/stripe/fast_kernels.h"
#include "tests/firmware/stripe/fast_cases.h"
#include "tests/firmware/stripe/temporal_trials.h"

namespace stria::test {
namespace {

bool same_bytes(const PulseMap& a, const PulseMap& b) {
    if (a.cell_begin != b.cell_begin || a.pulses.size() != b.pulses.size()) return false;
    for (std::size_t i = 0; i < a.pulses.size(); ++i) {
        const Pulse &p = a.pulses[i], &q = b.pulses[i];
        if (p.u != q.u || p.v != q.v || p.t_ns != q.t_ns || p.amplitude != q.amplitude ||
            p.width != q.width || p.background != q.background || p.sigma != q.sigma ||
            p.chi_square != q.chi_square || p.flags != q.flags)
            return false;
    }
    return true;
}

std::vector<FastCase> cases() {
    std::vector<FastCase> out;
    unsigned seed = 11;
    for (const double width : {0.6, 0.8, 1.5, 2.5, 5.0})
        for (const double snr : {8.0, 20.0, 60.0, 200.0})
            out.push_back({.height = 8, .width_frames = width, .snr = snr, .seed = seed++});
    out.push_back({.height = 8, .width_frames = 1.2, .exposure = 0.01, .seed = seed++});
    out.push_back(
        {.height = 8, .width_frames = 0.9, .exposure = 1.0, .odd_pixels = 1, .seed = seed});
    return out;
}

TEST(FastSpacetime, EqualsTheReferenceWithinWhatItStates) {
    std::uint64_t windows = 0, by_reference = 0;
    for (const FastCase& one : cases()) {
        SCOPED_TRACE("width " + std::to_string(one.width_frames) + ", SNR " +
                     std::to_string(one.snr) + ", seed " + std::to_string(one.seed));
        const FastSweep sweep = make_sweep(one);
        const Analysed reference = analyse(sweep, {}), fast = analyse(sweep, {.fast = true});
        expect_equal(compare(reference.map, fast.map, sweep.noise, 4e6));
        EXPECT_EQ(reference.map.undersampled, fast.map.undersampled);
        EXPECT_EQ(reference.map.saturated_samples, fast.map.saturated_samples);
        EXPECT_EQ(reference.sampling.samples_per_pulse, fast.sampling.samples_per_pulse);
        EXPECT_EQ(reference.windows.all, fast.windows.all);
        windows += fast.windows.all;
        by_reference += fast.windows.by_reference;
    }
    EXPECT_LT(by_reference, windows / 2);
}

TEST(FastSpacetime, GivesTheSameBytesOnEveryInstructionSetAndNumberOfThreads) {
    const FastSweep sweep = make_sweep({.width = 157, .seed = 5});
    const PulseMap one = analyse(sweep, {.fast = true}).map;
    EXPECT_GT(one.pulses.size(), 3000u);
    EXPECT_TRUE(same_bytes(one, analyse(sweep, {.threads = 3, .fast = true}).map));
    for (const char* set : fast::instruction_sets()) {
        fast::use_instruction_set(set);
        EXPECT_TRUE(same_bytes(one, analyse(sweep, {.fast = true}).map)) << set;
    }
    fast::use_instruction_set("");
    EXPECT_THROW(fast::use_instruction_set("abacus"), std::invalid_argument);
}

TEST(FastSpacetime, LeavesFewOfCleanPulsesToTheReference) {
    const FastSweep sweep = make_sweep({.snr = 50, .odd_pixels = 0, .seed = 8});
    const Analysed fast = analyse(sweep, {.fast = true});
    EXPECT_GE(fast.map.pulses.size(), 3600u);
    EXPECT_LT(fast.windows.by_reference, fast.windows.all / 50);
}

TEST(FastTemporalBound, IsReachedIn1000Trials) { expect_fast_reaches_bound(1000, {10, 30, 200}); }

}  // namespace
}  // namespace stria::test

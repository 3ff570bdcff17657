#include "firmware/stripe/fast_spacetime.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

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

/// Greatest mean error (frames) over 40 places within a frame, of pulses without noise. Dither of
/// one DN before rounding takes the format's steps out of the mean of 300 pixels.
double greatest_bias(double width_frames) {
    constexpr int kPhases = 40, kColumns = 300, kFrames = 44;
    std::mt19937_64 rng(7);
    std::uniform_real_distribution<double> dither(0, 1);
    const SensorNoise noise = {.gain_e_per_dn = 1e9, .read_noise_e = 0.29e9};
    SpacetimeAnalyser analyser(kColumns, kPhases, 8, noise, {.fast = true});
    for (int k = 0; k < kFrames; ++k) {
        Frame frame;
        resize(frame, kColumns, kPhases, 8);
        frame.sequence = static_cast<std::uint32_t>(k);
        frame.exposure_ns = 800'000;
        frame.exposure_start_ns = k * kNsPerMs;
        const double middle = static_cast<double>(frame.row_time(0)) * 1e-6;
        for (int y = 0; y < kPhases; ++y) {
            const TruePulse pulse{200, 22 + 1.0 * y / kPhases, width_frames, 20};
            const double mean = expected_sample(pulse, middle, 0.4);
            for (int x = 0; x < kColumns; ++x)
                set_sample(frame, x, y, static_cast<int>(mean + dither(rng)));
        }
        analyser.add(std::move(frame));
    }
    const PulseMap map = analyser.finish();
    EXPECT_EQ(map.pulses.size(), std::size_t{kPhases} * kColumns);
    EXPECT_LT(analyser.windows().by_reference, analyser.windows().all / 20);
    double greatest = 0;
    for (int y = 0; y < kPhases; ++y) {
        double sum = 0;
        for (int x = 0; x < kColumns; ++x)
            sum += static_cast<double>(map.cell(x, y)[0].t_ns) * 1e-6 - 22 - 1.0 * y / kPhases;
        greatest = std::max(greatest, std::abs(sum / kColumns));
    }
    return greatest;
}

TEST(FastSpacetime, HasNoBiasWithoutNoise) {
    for (const double width : {0.6, 0.8, 1.0, 1.5, 2.5}) {
        const double bias = greatest_bias(width);
        std::printf("width %.1f frames: greatest bias %.5f frames\n", width, bias);
        EXPECT_LE(bias, 0.002) << width;  // frames
    }
}

TEST(FastTemporalBound, IsReachedIn1000Trials) { expect_fast_reaches_bound(1000, {10, 30, 200}); }

}  // namespace
}  // namespace stria::test

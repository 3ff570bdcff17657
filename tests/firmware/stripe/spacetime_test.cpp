#include "firmware/stripe/spacetime.h"

#include <gtest/gtest.h>

#include "tests/firmware/stripe/temporal_trials.h"

namespace stria::test {
namespace {

constexpr TimeNs kPeriodNs = 1'000'000;

/// A sweep of a few pixels: pulse k of pixel (x, y) as `pulses` says, in frame periods.
struct Sweep {
    int width = 20, height = 6, bits = 12, frames = 60;
    SensorNoise noise = {.gain_e_per_dn = 1e9, .read_noise_e = 20e9};
    std::vector<TruePulse> pulses;
    double full_exposure = 0.9;

    Frame frame(int k, std::mt19937_64& rng) const {
        Frame out;
        resize(out, width, height, bits);
        out.sequence = static_cast<std::uint32_t>(k);
        out.exposure_ns = static_cast<TimeNs>(full_exposure * static_cast<double>(kPeriodNs));
        out.exposure_start_ns = k * kPeriodNs - out.exposure_ns / 2;
        for (int y = 0; y < height; ++y) {
            for (int x = 0; x < width; ++x) {
                double mean = 0;
                for (const TruePulse& p : pulses)
                    mean += expected_sample(p, k, 0.5 * full_exposure);
                set_sample(out, x, y, noisy_sample(mean, noise, out.full_scale(), rng));
            }
        }
        return out;
    }

    PulseMap analyse(const SpacetimeOptions& options = {}, unsigned seed = 1) const {
        std::mt19937_64 rng(seed);
        SpacetimeAnalyser analyser(width, height, bits, noise, options);
        for (int k = 0; k < frames; ++k) analyser.add(frame(k, rng));
        return analyser.finish();
    }
};

TEST(Spacetime, FindsTheTimeOfEveryPixel) {
    Sweep sweep;
    sweep.pulses = {{2000, 30.25, 2.0, 200}};
    const PulseMap map = sweep.analyse();
    ASSERT_TRUE(is_valid(map));
    EXPECT_EQ(map.frames, 60u);
    EXPECT_EQ(map.frames_dropped, 0u);
    EXPECT_FALSE(map.undersampled);
    for (int y = 0; y < sweep.height; ++y) {
        for (int x = 0; x < sweep.width; ++x) {
            ASSERT_EQ(map.cell(x, y).size(), 1u);
            const Pulse& p = map.cell(x, y)[0];
            EXPECT_NEAR(static_cast<double>(p.t_ns) / kPeriodNs, 30.25, 6 * p.sigma / kPeriodNs);
            EXPECT_NEAR(p.width / kPeriodNs, 2.0, 0.15);
            EXPECT_NEAR(p.background, 200, 30);
            EXPECT_EQ(p.u, x);
            EXPECT_EQ(p.v, y);
            EXPECT_EQ(p.flags, 0);
        }
    }
}

TEST(Spacetime, HasNoBiasWithoutNoise) {
    for (const double width : {0.6, 0.8, 1.5, 3.0}) {
        for (int phase = 0; phase < 10; ++phase) {
            Sweep sweep;
            sweep.bits = 16;
            sweep.noise.read_noise_e = 0;
            sweep.width = sweep.height = 1;
            sweep.pulses = {{50000, 30 + phase / 10.0, width, 1000}};
            const PulseMap map = sweep.analyse();
            ASSERT_EQ(map.pulses.size(), 1u) << width << " " << phase;
            EXPECT_NEAR(static_cast<double>(map.pulses[0].t_ns) / kPeriodNs,
                        sweep.pulses[0].position, 0.002);  // frame periods
        }
    }
}

TEST(Spacetime, SurvivesFourfoldSaturation) {
    for (const double width : {1.0, 1.5, 2.5}) {
        const LocalisationCell cell =
            measure_temporal({.width_frames = width, .snr = 60, .saturation = 4}, 2000, 77);
        // Up to 1 % of the narrow ones are refused: their height and width cannot be told apart
        // from the few unclipped samples, and the fit runs away.
        EXPECT_GE(cell.found, 0.99) << width;
        EXPECT_LE(cell.ratio(), 1.3) << width;
        EXPECT_LT(std::abs(cell.mean), 0.01) << width;  // frame periods
        EXPECT_GT(cell.sigma_ratio, 0.9) << width;
        EXPECT_LT(cell.sigma_ratio, 1.1) << width;
    }
}

TEST(Spacetime, KeepsTwoPulsesOfAPixel) {
    for (const double apart : {3.0, 5.0, 8.0, 20.0}) {  // frame periods, width 1.5
        Sweep sweep;
        sweep.frames = 80;
        sweep.pulses = {{2000, 30.3, 1.5, 100}, {1200, 30.3 + 1.5 * apart, 1.5, 0}};
        const PulseMap map = sweep.analyse();
        int pairs = 0;
        for (int y = 0; y < sweep.height; ++y) {
            for (int x = 0; x < sweep.width; ++x) {
                const auto cell = map.cell(x, y);
                if (cell.size() != 2) continue;
                ++pairs;
                EXPECT_NEAR(static_cast<double>(cell[0].t_ns) / kPeriodNs, 30.3, 0.2);
                EXPECT_NEAR(static_cast<double>(cell[1].t_ns) / kPeriodNs, 30.3 + 1.5 * apart, 0.3);
                EXPECT_TRUE(apart > 4 || (cell[0].flags & kPulseOverlapping));
            }
        }
        EXPECT_GE(pairs, 118) << apart;  // of 120
    }
}

TEST(Spacetime, DoesNotDependOnThreads) {
    Sweep sweep;
    sweep.height = 37;
    sweep.pulses = {{900, 30.25, 2.0, 200}, {300, 40, 2.0, 0}};
    const PulseMap one = sweep.analyse({.threads = 1});
    for (const int threads : {2, 3, 64}) {
        const PulseMap many = sweep.analyse({.threads = threads});
        EXPECT_EQ(one.cell_begin, many.cell_begin);
        ASSERT_EQ(one.pulses.size(), many.pulses.size());
        for (std::size_t i = 0; i < one.pulses.size(); ++i) {
            EXPECT_EQ(one.pulses[i].t_ns, many.pulses[i].t_ns);
            EXPECT_EQ(one.pulses[i].sigma, many.pulses[i].sigma);
        }
    }
}

TEST(Spacetime, ClaimsNothingWhereNothingPasses) {
    for (const double level : {0.0, 200.0, 4095.0}) {  // dark, grey, saturated
        for (const int frames : {0, 1, 2, 7, 8, 9, 40}) {
            Sweep sweep;
            sweep.frames = frames;
            sweep.noise.read_noise_e = level == 200.0 ? 20e9 : 0;
            sweep.pulses = {{0, 0, 1, level}};
            const PulseMap map = sweep.analyse();
            EXPECT_TRUE(is_valid(map));
            EXPECT_TRUE(map.pulses.empty()) << level << " " << frames;
            EXPECT_FALSE(map.undersampled);
            const int saturated = level == 4095.0 ? frames * 120 : 0;
            EXPECT_EQ(map.saturated_samples, static_cast<std::uint32_t>(saturated));
        }
    }
}

TEST(Spacetime, FollowsALampThatIsSwitchedOn) {
    // Brighter from frame 20 on, for longer than any pulse, then a pulse: only that one counts.
    Sweep sweep;
    sweep.frames = 260;
    sweep.pulses = {{2000, 230, 2.0, 100}};
    std::mt19937_64 rng(1);
    SpacetimeAnalyser analyser(sweep.width, sweep.height, sweep.bits, sweep.noise);
    for (int k = 0; k < sweep.frames; ++k) {
        sweep.pulses[0].background = k < 20 ? 100 : 600;
        analyser.add(sweep.frame(k, rng));
    }
    const PulseMap map = analyser.finish();
    for (int y = 0; y < sweep.height; ++y) {
        for (int x = 0; x < sweep.width; ++x) {
            ASSERT_EQ(map.cell(x, y).size(), 1u);
            EXPECT_NEAR(static_cast<double>(map.cell(x, y)[0].t_ns) / kPeriodNs, 230, 0.2);
        }
    }
}

TEST(Spacetime, FlagsPulsesThatTheSweepCutsOff) {
    for (const double at : {1.0, 58.0}) {
        Sweep sweep;
        sweep.pulses = {{2000, at, 2.0, 100}};
        const PulseMap map = sweep.analyse();
        for (const Pulse& p : map.pulses) EXPECT_TRUE(p.flags & kPulseTouchesSequenceEnd) << at;
        EXPECT_GE(map.pulses.size(), at > 10 ? 100u : 0u);
    }
}

TEST(Spacetime, CountsLostFramesAndIgnoresRepeatedOnes) {
    Sweep sweep;
    sweep.pulses = {{2000, 30.25, 2.5, 200}};
    std::mt19937_64 rng(1);
    SpacetimeAnalyser analyser(sweep.width, sweep.height, sweep.bits, sweep.noise);
    for (int k = 0; k < sweep.frames; ++k) {
        if (k == 28 || k == 31 || k == 50) continue;  // lost
        const Frame frame = sweep.frame(k, rng);
        analyser.add(frame);
        if (k == 10) analyser.add(frame);                 // a duplicate
        if (k == 20) analyser.add(sweep.frame(12, rng));  // out of order
    }
    const PulseMap map = analyser.finish();
    EXPECT_EQ(analyser.frames_ignored(), 2);
    EXPECT_EQ(map.frames_dropped, 3u);
    EXPECT_EQ(map.frames, 57u);
    for (int y = 0; y < sweep.height; ++y) {
        for (int x = 0; x < sweep.width; ++x) {
            ASSERT_EQ(map.cell(x, y).size(), 1u);
            const Pulse& p = map.cell(x, y)[0];  // true times: a gap moves nothing
            EXPECT_NEAR(static_cast<double>(p.t_ns) / kPeriodNs, 30.25, 6 * p.sigma / kPeriodNs);
        }
    }
}

TEST(Spacetime, SaysThatASweepIsUndersampled) {
    // A stripe 2 px wide that moves `step` px a frame over 8-bit frames of 200 x 40.
    for (const double step : {1.0, 2.0, 8.0, 25.0}) {
        Sweep sweep;
        SpacetimeAnalyser analyser(200, 40, 8, {.gain_e_per_dn = 40, .read_noise_e = 40});
        std::mt19937_64 rng(1);
        for (int k = 0; k * step < 260; ++k) {
            Frame frame;
            resize(frame, 200, 40, 8);
            frame.sequence = static_cast<std::uint32_t>(k);
            frame.exposure_start_ns = k * kPeriodNs;
            frame.exposure_ns = kPeriodNs / 10;
            for (int y = 0; y < 40; ++y)
                for (int x = 0; x < 200; ++x)
                    set_sample(frame, x, y,
                               noisy_sample(expected_sample({150, k * step - 30, 2.0, 10}, x, 0.5),
                                            {.gain_e_per_dn = 40, .read_noise_e = 40}, 255, rng));
            analyser.add(frame);
        }
        const PulseMap map = analyser.finish();
        EXPECT_EQ(map.undersampled, step > 4) << step;
        EXPECT_EQ(map.pulses.empty(), step > 4) << step;
        EXPECT_NEAR(analyser.sampling().step_px, step, 0.2);
        EXPECT_NEAR(analyser.sampling().width_px, 2.0, 0.1);
    }
}

TEST(Spacetime, AnswersSanelyToAnyFrames) {
    std::mt19937_64 rng(5);
    for (int trial = 0; trial < 24; ++trial) {
        const int bits = trial % 2 ? 8 : 11, width = 1 + static_cast<int>(rng() % 70), height = 3;
        SpacetimeAnalyser analyser(width, height, bits, {.gain_e_per_dn = 10, .read_noise_e = 20});
        std::vector<int> level(static_cast<std::size_t>(width * height), 50);
        TimeNs time = -5'000'000'000;
        for (int k = 0; k < 90; ++k) {
            Frame frame;
            resize(frame, width, height, bits);
            time += 1 + static_cast<TimeNs>(rng() % 3'000'000);
            frame.exposure_start_ns = time;
            frame.exposure_ns = trial % 3 ? 500'000 : 0;
            frame.sequence = static_cast<std::uint32_t>(k + static_cast<int>(rng() % 2) * 3);
            for (std::size_t i = 0; i < level.size(); ++i) {
                if (rng() % 10 == 0) level[i] = static_cast<int>(rng() % 4096);
                if (rng() % 4 == 0) level[i] = level[i] / 2;
                set_sample(frame, static_cast<int>(i) % width, static_cast<int>(i) / width,
                           std::min(level[i], frame.full_scale()));
            }
            analyser.add(frame);
        }
        const PulseMap map = analyser.finish();
        EXPECT_TRUE(is_valid(map)) << trial;
        for (const Pulse& p : map.pulses) EXPECT_GT(p.sigma, 0.0f) << trial;
    }
}

TEST(Spacetime, RefusesFramesOfAnotherKind) {
    SpacetimeAnalyser analyser(20, 10, 8, {});
    Frame frame;
    resize(frame, 20, 11, 8);
    EXPECT_THROW(analyser.add(frame), std::invalid_argument);
    resize(frame, 20, 10, 12);
    EXPECT_THROW(analyser.add(frame), std::invalid_argument);
    EXPECT_THROW(SpacetimeAnalyser(0, 10, 8, {}), std::invalid_argument);
    EXPECT_THROW(SpacetimeAnalyser(10, 10, 8, {}, {.max_pulse_frames = 1000}),
                 std::invalid_argument);
}

}  // namespace
}  // namespace stria::test

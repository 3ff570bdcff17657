#include "firmware/stripe/spatial.h"

#include <gtest/gtest.h>

#include "firmware/stripe/noise_estimate.h"
#include "tests/firmware/stripe/row_frames.h"

namespace stria::test {
namespace {

TEST(SpatialPeaks, HaveNoBiasWithoutNoise) {
    for (const double width : {0.6, 0.8, 1.5, 2.5, 4.0}) {
        for (int phase = 0; phase < 40; ++phase) {
            const TruePulse truth{50000, 30.0 + phase / 40.0, width, 1000};
            const Frame frame = frame_of(64, 1, 16, {truth}, kSilent, 1);
            const auto peaks = find_peaks(frame, kSilent);
            ASSERT_EQ(peaks.size(), 1u) << width << " " << phase;
            EXPECT_NEAR(peaks[0].u, truth.position, 0.002);  // px, as asked of the method
            EXPECT_NEAR(peaks[0].width, truth.width, 0.002);
            EXPECT_NEAR(peaks[0].amplitude, truth.amplitude, 0.002 * truth.amplitude);
        }
    }
}

TEST(SpatialPeaks, CarryRowAndTime) {
    Frame frame = frame_of(64, 12, 12, {{2000, 30.3, 1.5, 100}}, sensor_for(2000, 50, false), 2);
    frame.laser_id = 3;
    frame.exposure_start_ns = 5'000'000;
    const auto peaks = find_peaks(frame, sensor_for(2000, 50, false));
    ASSERT_EQ(peaks.size(), 12u);
    for (int y = 0; y < 12; ++y) {
        EXPECT_EQ(peaks[y].v, y);
        EXPECT_EQ(peaks[y].t_ns, frame.row_time(y));
        EXPECT_EQ(peaks[y].laser_id, 3);
        EXPECT_EQ(peaks[y].flags, 0);
    }
}

TEST(SpatialPeaks, SurviveFourfoldSaturation) {
    // Full scale is a quarter of the pulse's height: only the flanks say where it is.
    for (const double width : {1.0, 1.5, 2.5}) {
        const SensorNoise noise = sensor_for(4095, 60, false);
        LocalisationTally tally;
        std::mt19937_64 rng(5);
        std::uniform_real_distribution<double> place(30.0, 31.0);
        std::vector<double> x(64);
        for (int i = 0; i < 64; ++i) x[i] = i;
        for (int trial = 0; trial < 2000; ++trial) {
            const TruePulse truth{4 * 4095, place(rng), width, 100};
            const Frame frame = frame_of(64, 1, 12, {truth}, noise, 1000 + trial);
            const auto peaks = find_peaks(frame, noise);
            if (peaks.size() != 1) {
                tally.add_missing();
                continue;
            }
            EXPECT_TRUE(peaks[0].flags & kPulseSaturated);
            tally.add(peaks[0].u - truth.position, peaks[0].sigma,
                      cramer_rao_bound(truth, x, 0.5, noise, 4094.5));
        }
        const LocalisationCell cell = tally.cell();
        EXPECT_GE(cell.found, 0.998) << width;
        EXPECT_LE(cell.ratio(), 1.3) << width;          // of the censored model's bound
        EXPECT_LT(std::abs(cell.mean), 0.01) << width;  // px
        EXPECT_GT(cell.sigma_ratio, 0.9) << width;
        EXPECT_LT(cell.sigma_ratio, 1.1) << width;
    }
}

TEST(SpatialPeaks, TellTwoStripesApart) {
    const SensorNoise noise = sensor_for(2000, 60, false);
    for (const double apart : {3.0, 4.0, 6.0, 12.0, 25.0}) {  // widths
        const TruePulse strong{2000, 30.2, 1.5, 100};
        const TruePulse weak{900, 30.2 + 1.5 * apart, 1.5, 0};
        const Frame frame = frame_of(100, 50, 12, {strong, weak}, noise, 7);
        const auto peaks = find_peaks(frame, noise);
        int pairs = 0;
        for (std::size_t i = 0; i + 1 < peaks.size(); ++i) {
            if (peaks[i].v != peaks[i + 1].v) continue;
            EXPECT_NEAR(peaks[i].u, strong.position, 0.3) << apart;
            EXPECT_NEAR(peaks[i + 1].u, weak.position, 0.5) << apart;
            ++pairs;
        }
        EXPECT_GE(pairs, 49) << apart << " widths";
    }
}

TEST(SpatialPeaks, AreNotClaimedWhereNoStripeIs) {
    const SensorNoise noise = sensor_for(200, 20, false);
    for (const int level : {0, 100, 255}) {  // dark, grey, saturated
        Frame frame = frame_of(200, 100, 8, {{0, 50, 1, static_cast<double>(level)}}, noise, 3);
        EXPECT_TRUE(find_peaks(frame, noise).empty()) << level;
        std::fill(frame.bytes.begin(), frame.bytes.end(), static_cast<std::uint8_t>(level));
        EXPECT_TRUE(find_peaks(frame, kSilent).empty()) << level;
    }
    for (const int side : {1, 4, 7, 8, 9})
        EXPECT_TRUE(find_peaks(frame_of(side, side, 8, {}, kSilent, 1), kSilent).empty());
    EXPECT_TRUE(find_peaks(Frame{}, kSilent).empty());
}

TEST(SpatialPeaks, AreNotClaimedAtAStep) {
    Frame frame;
    resize(frame, 100, 20, 8);
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 100; ++x) set_sample(frame, x, y, x < 50 ? 20 : 180);
    EXPECT_TRUE(find_peaks(frame, kSilent).empty());
}

TEST(SpatialPeaks, DoNotDependOnThreads) {
    const SensorNoise noise = sensor_for(150, 15, true);
    const Frame frame = frame_of(300, 101, 8, {{150, 100, 2, 20}, {90, 200, 1, 0}}, noise, 9);
    const auto one = find_peaks(frame, noise, {.min_run_rows = 3, .threads = 1});
    for (const int threads : {2, 3, 7, 200}) {
        const auto many = find_peaks(frame, noise, {.min_run_rows = 3, .threads = threads});
        ASSERT_EQ(one.size(), many.size());
        for (std::size_t i = 0; i < one.size(); ++i) {
            EXPECT_EQ(one[i].u, many[i].u);
            EXPECT_EQ(one[i].sigma, many[i].sigma);
        }
    }
}

TEST(SpatialPeaks, OfAnyImageAreFiniteAndInside) {
    std::mt19937_64 rng(11);
    for (int trial = 0; trial < 300; ++trial) {
        Frame frame;
        const int bits = trial % 2 ? 8 : 12;
        resize(frame, 1 + static_cast<int>(rng() % 90), 1 + static_cast<int>(rng() % 6), bits);
        const int kind = static_cast<int>(rng() % 4);
        int level = frame.full_scale() / 2;
        for (int y = 0; y < frame.height; ++y) {
            for (int x = 0; x < frame.width; ++x) {
                if (kind == 0) level = static_cast<int>(rng());
                if (kind == 1 && rng() % 5 == 0) level = static_cast<int>(rng());
                if (kind == 2) level += static_cast<int>(rng() % 41) - 20;
                if (kind == 3) level = rng() % 3 ? 0 : frame.full_scale();
                set_sample(
                    frame, x, y,
                    std::clamp(std::abs(level) % (2 * frame.full_scale()), 0, frame.full_scale()));
            }
        }
        const SensorNoise noise = {.gain_e_per_dn = trial % 3 ? 40.0 : 1e9,
                                   .read_noise_e = trial % 5 ? 10.0 : 0.0};
        SpatialAnalyser analyser(frame.height, noise, {.max_peaks_per_row = 1 + trial % 4});
        analyser.add(frame);
        const PulseMap map = analyser.finish();
        EXPECT_TRUE(is_valid(map)) << trial;
        for (const Pulse& p : map.pulses) {
            EXPECT_GE(p.u, -0.5f) << trial;
            EXPECT_LE(p.u, static_cast<float>(frame.width) - 0.5f) << trial;
            EXPECT_GT(p.sigma, 0.0f) << trial;
        }
    }
}

TEST(SpatialAnalyser, LaysFramesSideBySideAndCountsDrops) {
    const SensorNoise noise = sensor_for(2000, 50, false);
    Frame frame = frame_of(64, 5, 12, {{2000, 30.3, 1.5, 100}}, noise, 2);
    SpatialAnalyser analyser(5, noise);
    const auto add = [&](std::uint32_t sequence, TimeNs time) {
        frame.sequence = sequence;
        frame.exposure_start_ns = time;
        analyser.add(frame);
    };
    add(10, 100);
    add(11, 200);
    add(11, 300);  // a duplicate
    add(9, 400);   // out of order
    add(15, 500);  // three lost
    EXPECT_EQ(analyser.frames_ignored(), 2);
    const PulseMap map = analyser.finish();
    EXPECT_TRUE(is_valid(map));
    EXPECT_EQ(map.width, 3);
    EXPECT_EQ(map.height, 5);
    EXPECT_EQ(map.frames, 3u);
    EXPECT_EQ(map.frames_dropped, 3u);
    for (int y = 0; y < 5; ++y)
        for (int k = 0; k < 3; ++k) EXPECT_EQ(map.cell(k, y).size(), 1u);
    EXPECT_EQ(map.cell(2, 4)[0].t_ns, frame.row_time(4));
    Frame other;
    resize(other, 64, 6, 12);
    EXPECT_THROW(analyser.add(other), std::invalid_argument);
}

TEST(SpatialOptions, NameTheWrongField) {
    try {
        SpatialOptions{.max_peaks_per_row = 9}.validate();
        FAIL();
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("max_peaks_per_row"), std::string::npos);
    }
}

TEST(NoiseEstimate, FindsReadAndShotNoise) {
    // A ramp of brightness: read noise 3 DN, 8 electrons a DN.
    const SensorNoise truth = {.gain_e_per_dn = 8, .read_noise_e = 24};
    std::mt19937_64 rng(4);
    Frame frame;
    resize(frame, 800, 300, 12);
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            set_sample(frame, x, y, noisy_sample(100 + 4.0 * x, truth, 4095, rng));
    const SensorNoise found = estimate_noise({&frame, 1});
    for (const double level : {200.0, 1000.0, 3000.0})
        EXPECT_NEAR(std::sqrt(sample_variance(found, level) / sample_variance(truth, level)), 1.0,
                    0.05)  // of 240 000 samples: the estimator's own spread is below 1 %
            << level;
}

TEST(NoiseEstimate, OfNoiselessFramesIsQuantisationAlone) {
    Frame frame;
    resize(frame, 100, 100, 8);
    const SensorNoise found = estimate_noise({&frame, 1});
    EXPECT_EQ(found.read_noise_e, 0.0);
    EXPECT_NEAR(sample_variance(found, 200), 1.0 / 12.0, 1e-3);
    EXPECT_EQ(estimate_noise({}).read_noise_e, 0.0);
}

}  // namespace
}  // namespace stria::test

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "firmware/stripe/spatial.h"
#include "tests/firmware/stripe/cramer_rao.h"
#include "tests/firmware/stripe/row_frames.h"
#include "tests/firmware/stripe/temporal_trials.h"

namespace stria::test {
namespace {

constexpr int kTrials = 20000;

/// The bound is that of the censored model.
void expect_censored_bound(const char* kind, double width, double snr,
                           const LocalisationCell& cell) {
    std::printf("%-8s width %.1f snr %3.0f: rms / bound %.3f, mean %+.4f, sigma %.3f, found %.4f\n",
                kind, width, snr, cell.ratio(), cell.mean, cell.sigma_ratio, cell.found);
    EXPECT_GE(cell.found, 0.99);
    EXPECT_LE(cell.ratio(), 1.3);
    EXPECT_LT(std::abs(cell.mean), 0.01);  // px, frame periods
}

LocalisationCell measure_clipped_stripes(double width, double snr) {
    const SensorNoise noise = sensor_for(4095, snr, false);
    LocalisationTally tally;
    std::mt19937_64 rng(5);
    std::uniform_real_distribution<double> place(30.0, 31.0);
    std::vector<double> x(64);
    for (int i = 0; i < 64; ++i) x[i] = i;
    for (int trial = 0; trial < kTrials; ++trial) {
        const TruePulse truth{4 * 4095, place(rng), width, 100};
        const Frame frame = frame_of(64, 1, 12, {truth}, noise, 1000 + trial);
        const auto peaks = find_peaks(frame, noise);
        if (peaks.size() != 1)
            tally.add_missing();
        else
            tally.add(peaks[0].u - truth.position, peaks[0].sigma,
                      cramer_rao_bound(truth, x, 0.5, noise, 4094.5));
    }
    return tally.cell();
}

TEST(FourfoldSaturation, SpatialPeaksIn20000Trials) {
    for (const double width : {1.0, 1.5, 2.5})
        for (const double snr : {20.0, 60.0, 200.0})
            expect_censored_bound("spatial", width, snr, measure_clipped_stripes(width, snr));
}

TEST(FourfoldSaturation, SpacetimePulsesIn20000Trials) {
    for (const double width : {1.0, 1.5, 2.5})
        for (const double snr : {20.0, 60.0, 200.0})
            expect_censored_bound(
                "temporal", width, snr,
                measure_temporal({.width_frames = width, .snr = snr, .saturation = 4}, kTrials,
                                 77));
}

TEST(TwofoldToSixteenfoldSaturation, NarrowPulsesAreFoundAndTheirErrorIsBounded) {
    for (const double saturation : {2.0, 8.0, 16.0})
        for (const double snr : {20.0, 60.0}) {
            std::printf("clipped %2.0f x: ", saturation);
            expect_censored_bound(
                "temporal", 1.0, snr,
                measure_temporal({.width_frames = 1.0, .snr = snr, .saturation = saturation},
                                 kTrials, 78));
        }
}

}  // namespace
}  // namespace stria::test

#include "firmware/stripe/gaussian_fit.h"

#include <gtest/gtest.h>

#include "tests/firmware/stripe/localisation.h"

namespace stria {
namespace {

constexpr double kFullScale = 4095;
constexpr double kWidth = 1.2;
constexpr int kSamples = 25;
constexpr int kTrials = 500;

const FitStart kStart = {.position = 12, .amplitude = 1500, .width = 1.5, .background = 100};

FitStart with_unlike_widths() {
    FitStart start = kStart;
    start.widths_may_differ = true;
    return start;
}

/// Samples of a pulse of kWidth at `centre` and one of `width` beside it, `off` widths of kWidth
/// away and of that height.
FitSamples unlike_pulses(double centre, double off, double width, double height,
                         const SensorNoise& noise, std::mt19937_64& rng) {
    FitSamples samples;
    samples.count = 40;
    for (int i = 0; i < samples.count; ++i) {
        const double mean =
            test::expected_sample({2000, centre, kWidth, 100}, i, 0.5) +
            test::expected_sample({height, centre + off * kWidth, width, 0}, i, 0.5);
        samples.x[i] = i;
        samples.y[i] = test::noisy_sample(mean, noise, kFullScale, rng);
        samples.saturated[i] = 0;
    }
    return samples;
}

/// Samples of `parts` equal pulses spread evenly over `length` about `centre`.
FitSamples spread_pulse(int parts, double length, double centre, const SensorNoise& noise,
                        std::mt19937_64& rng) {
    FitSamples samples;
    samples.count = kSamples;
    for (int i = 0; i < kSamples; ++i) {
        double mean = 100;
        for (int k = 0; k < parts; ++k) {
            const double position = centre + length * ((k + 0.5) / parts - 0.5);
            mean += test::expected_sample({2000.0 / parts, position, kWidth, 0}, i, 0.5);
        }
        samples.x[i] = i;
        samples.y[i] = test::noisy_sample(mean, noise, kFullScale, rng);
        samples.saturated[i] = 0;
    }
    return samples;
}

// A pixel on a steep surface sees the beam convolved with its own footprint.
/// Light spread over `length` widths about a place, 500 times.
void expect_one_in_the_middle(double length, const FitStart& start, std::mt19937_64& rng) {
    std::uniform_real_distribution<double> place(11.5, 12.5);
    const SensorNoise noise = test::sensor_for(2000, 50, true);
    double squares = 0, predicted = 0;
    int split = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        const double centre = place(rng);
        const GaussianFit fit = fit_pulses(spread_pulse(40, length * kWidth, centre, noise, rng),
                                           noise, kFullScale, start, 50);
        ASSERT_TRUE(fit.converged);
        split += fit.peaks > 1;
        const double sigma = fit.sigma[0] * sigma_inflation(fit);
        squares += (fit.position[0] - centre) * (fit.position[0] - centre);
        predicted += sigma * sigma;
    }
    EXPECT_LE(split, kTrials / 100) << "length " << length << " widths";
    EXPECT_NEAR(std::sqrt(squares / predicted), 1.0, 0.15) << "length " << length;
}

TEST(FitPulses, LightSpreadByATiltedSurfaceIsOnePulseInItsMiddle) {
    for (const FitStart& start : {kStart, with_unlike_widths()}) {
        std::mt19937_64 rng(5);
        for (const double length : {1.5, 2.5, 3.5}) expect_one_in_the_middle(length, start, rng);
    }
}

TEST(FitPulses, TwoPulsesWithTwoMaximaAreTold) {
    std::mt19937_64 rng(6);
    const SensorNoise noise = test::sensor_for(1000, 50, true);
    int told = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        // Two parts over twice their distance stand at +-3/2 widths.
        const GaussianFit fit = fit_pulses(spread_pulse(2, 6 * kWidth, 12.2, noise, rng), noise,
                                           kFullScale, kStart, 50);
        if (fit.peaks != 2) continue;
        ++told;
        const double low = std::min(fit.position[0], fit.position[1]);
        const double high = std::max(fit.position[0], fit.position[1]);
        EXPECT_NEAR(low, 12.2 - 1.5 * kWidth, 0.3);
        EXPECT_NEAR(high, 12.2 + 1.5 * kWidth, 0.3);
    }
    EXPECT_EQ(told, kTrials);
}

TEST(FitPulses, TwoThatOverlapTooFarAreOneMarkedUnresolved) {
    std::mt19937_64 rng(7);
    const SensorNoise noise = test::sensor_for(1000, 400, true);
    int marked = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        const GaussianFit fit = fit_pulses(spread_pulse(2, 3.6 * kWidth, 12.2, noise, rng), noise,
                                           kFullScale, kStart, 50);
        EXPECT_EQ(fit.peaks, 1);
        marked += fit.unresolved;
    }
    EXPECT_GT(marked, kTrials * 9 / 10);
}

// What another surface throws on a pixel lasts longer than the beam's own pulse.
TEST(FitPulses, ABroadPulseBesideASharpOneLeavesItsPlaceAndSigmaTrue) {
    std::mt19937_64 rng(8);
    std::uniform_real_distribution<double> place(17.5, 18.5);
    const SensorNoise noise = test::sensor_for(2000, 100, true);
    for (const double off : {3.0, -3.0}) {
        double squares = 0, predicted = 0, alike = 0;
        int told = 0;
        for (int trial = 0; trial < kTrials; ++trial) {
            const double centre = place(rng);
            const FitSamples samples = unlike_pulses(centre, off, 2.5 * kWidth, 800, noise, rng);
            FitStart start = with_unlike_widths();
            start.position = 18;
            const GaussianFit fit = fit_pulses(samples, noise, kFullScale, start, 50);
            if (fit.peaks != 2) continue;
            ++told;
            squares += (fit.position[0] - centre) * (fit.position[0] - centre);
            predicted += fit.sigma[0] * fit.sigma[0];
            start.widths_may_differ = false;
            const double error =
                fit_pulses(samples, noise, kFullScale, start, 50).position[0] - centre;
            alike += error * error;
        }
        EXPECT_GE(told, kTrials * 99 / 100);
        EXPECT_NEAR(std::sqrt(squares / predicted), 1.0, 0.1);  // 500 trials: 0.03
        EXPECT_GT(alike, 25 * squares) << "a common width would do nearly as well";
    }
}

TEST(FitPulses, APulseOverItsOwnPedestalIsNotTornApart) {
    std::mt19937_64 rng(9);
    const SensorNoise noise = test::sensor_for(2000, 100, true);
    for (int trial = 0; trial < kTrials; ++trial) {
        const FitSamples samples = unlike_pulses(18.3, 0, 3 * kWidth, 400, noise, rng);
        FitStart start = kStart;
        start.position = 18;
        const GaussianFit alike = fit_pulses(samples, noise, kFullScale, start, 50);
        start.widths_may_differ = true;
        const GaussianFit fit = fit_pulses(samples, noise, kFullScale, start, 50);
        EXPECT_EQ(fit.peaks, alike.peaks);
        EXPECT_EQ(fit.position[0], alike.position[0]);
    }
}

}  // namespace
}  // namespace stria

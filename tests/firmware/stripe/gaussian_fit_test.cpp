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
TEST(FitPulses, LightSpreadByATiltedSurfaceIsOnePulseInItsMiddle) {
    std::mt19937_64 rng(5);
    std::uniform_real_distribution<double> place(11.5, 12.5);
    for (const double length : {1.5, 2.5, 3.5}) {
        const SensorNoise noise = test::sensor_for(2000, 50, true);
        double squares = 0, predicted = 0;
        int split = 0;
        for (int trial = 0; trial < kTrials; ++trial) {
            const double centre = place(rng);
            const GaussianFit fit =
                fit_pulses(spread_pulse(40, length * kWidth, centre, noise, rng), noise, kFullScale,
                           kStart, 50);
            ASSERT_TRUE(fit.converged);
            split += fit.peaks > 1;
            const double sigma = fit.sigma[0] * sigma_inflation(fit);
            squares += (fit.position[0] - centre) * (fit.position[0] - centre);
            predicted += sigma * sigma;
        }
        EXPECT_LE(split, kTrials / 100) << "length " << length << " widths";
        EXPECT_NEAR(std::sqrt(squares / predicted), 1.0, 0.15) << "length " << length;
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

}  // namespace
}  // namespace stria

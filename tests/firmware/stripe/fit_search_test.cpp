#include "firmware/stripe/fit_search.h"

#include <gtest/gtest.h>

#include "tests/firmware/stripe/localisation.h"

namespace stria::test {
namespace {

constexpr double kFullScale = 255, kHalfAperture = 0.4;

/// The least deviance, -2 log likelihood, of any pulse on a fine grid of places and widths: height
/// and background by least squares, weighted by the variances that they themselves give.
double least_deviance(const FitSamples& samples, const SensorNoise& noise, double max_width) {
    double least = 1e300;
    for (double width = 0.4; width <= max_width; width *= 1.04)
        for (double x = samples.x[0]; x <= samples.x[samples.count - 1]; x += 0.1 * width) {
            double height = 100, level = 50;
            for (int round = 0; round < 4; ++round) {
                double s1 = 0, sg = 0, sgg = 0, sy = 0, sgy = 0, deviance = 0;
                for (int i = 0; i < samples.count; ++i) {
                    const double g =
                        expected_sample({1.0, x, width, 0}, samples.x[i], kHalfAperture);
                    const double model = level + height * g, y = samples.y[i];
                    const double v = sample_variance(noise, model);
                    deviance += (y - model) * (y - model) / v + std::log(v);
                    s1 += 1 / v;
                    sg += g / v;
                    sgg += g * g / v;
                    sy += y / v;
                    sgy += g * y / v;
                }
                if (round > 0 && height > 0) least = std::min(least, deviance);
                height = (sgy * s1 - sg * sy) / (sgg * s1 - sg * sg);
                level = (sy - sg * height) / s1;
            }
        }
    return least;
}

/// A pulse on frames with jitter and gaps.
FitSamples pulse_of(double height, double place, double width, const SensorNoise& noise,
                    std::mt19937_64& rng) {
    std::uniform_real_distribution<double> jitter(-0.3, 0.3), share(0, 1);
    FitSamples samples;
    samples.half_aperture = kHalfAperture;
    for (int k = 0; k < 24; ++k) {
        if (share(rng) < 0.1) continue;  // a dropped frame
        const auto i = static_cast<std::size_t>(samples.count++);
        samples.x[i] = k + jitter(rng);
        const double mean = expected_sample({height, place, width, 60}, samples.x[i], 0.4);
        samples.y[i] = noisy_sample(mean, noise, kFullScale, rng);
        samples.saturated[i] = 0;
    }
    return samples;
}

// Started as the windows are where the light had not yet fallen when the background was first seen:
// from a background far too high and a narrow width.
TEST(FitPulses, FindsWhatAScanOfTheLikelihoodFinds) {
    std::mt19937_64 rng(17);
    std::uniform_real_distribution<double> place(6, 17), width(0.5, 4), start(3, 20);
    const SensorNoise noise = sensor_for(120, 40, true);
    int found = 0;
    constexpr int kTrials = 60;
    for (int trial = 0; trial < kTrials; ++trial) {
        const FitSamples samples = pulse_of(120, place(rng), width(rng), noise, rng);
        const FitStart from{.position = start(rng),
                            .amplitude = 13,
                            .width = 0.5,
                            .background = 150,
                            .min_width = 0.4,
                            .search = true};
        const GaussianFit fit = fit_pulses(samples, noise, kFullScale, from, 10);
        if (!fit.converged) continue;  // all of its samples may have been dropped
        ++found;
        if (fit.peaks == 1) {
            EXPECT_LE(fit.deviance, least_deviance(samples, noise, 6) + 0.1) << trial;
        }
    }
    EXPECT_GE(found, kTrials * 9 / 10);
}

TEST(SearchStart, StandsNearThePulse) {
    std::mt19937_64 rng(18);
    const SensorNoise noise = sensor_for(120, 40, true);
    for (const double width : {0.6, 1.0, 2.0, 4.0}) {
        const FitSamples samples = pulse_of(120, 11.3, width, noise, rng);
        const auto start = search_start(samples, noise, kFullScale, {.min_width = 0.4});
        ASSERT_TRUE(start) << width;
        EXPECT_NEAR(start->position, 11.3, width) << width;
        EXPECT_LT(std::abs(std::log(start->width / width)), 0.5) << width;
    }
}

TEST(SearchStart, IsNoneWhereNothingRises) {
    FitSamples samples;
    samples.count = 12;
    for (std::size_t i = 0; i < 12; ++i) {
        samples.x[i] = static_cast<double>(i);
        samples.y[i] = 40;
        samples.saturated[i] = 0;
    }
    EXPECT_FALSE(search_start(samples, {}, kFullScale, {}));
}

}  // namespace
}  // namespace stria::test

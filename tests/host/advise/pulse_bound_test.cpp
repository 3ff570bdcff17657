#include "host/advise/pulse_bound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/firmware/stripe/cramer_rao.h"

namespace stria {
namespace {

/// Camera noise that does not grow with the light.
SensorNoise additive(double sigma_dn) {
    return {.gain_e_per_dn = 1e12,
            .read_noise_e = 1e12 * std::sqrt(sigma_dn * sigma_dn - 1.0 / 12)};
}

TEST(PulseBound, TendsToTheClosedFormOfAdditiveNoise) {
    // accuracy.md A.4: sqrt(2 / sqrt(pi)) sqrt(sigma) / SNR, exact where the aperture is small.
    for (const double width : {1.5, 3.0, 10.0}) {
        const SampledPulse pulse{.amplitude_dn = 200,
                                 .width = width,
                                 .half_aperture = 0.002,
                                 .background_dn = 0,
                                 .full_scale_dn = 1e9};
        const double closed = std::sqrt(2 / std::sqrt(M_PI)) * std::sqrt(width) * 4 / 200;
        EXPECT_NEAR(position_bound(pulse, additive(4)) / closed, 1, 1e-6) << width;
    }
}

TEST(PulseBound, TendsToTheClosedFormOfShotNoise) {
    // sigma / sqrt(electrons): 0.632 sqrt(sigma / A_e), accuracy.md A.4.
    const SampledPulse pulse{.amplitude_dn = 1e6,
                             .width = 4,
                             .half_aperture = 0.01,
                             .background_dn = 0,
                             .full_scale_dn = 1e9};
    const SensorNoise noise{.gain_e_per_dn = 1, .read_noise_e = 0};
    const double electrons = 1e6 * 4 * std::sqrt(2 * M_PI);
    EXPECT_NEAR(position_bound(pulse, noise) / (4 / std::sqrt(electrons)), 1, 0.005);
}

TEST(PulseBound, PixelsAsWideAsTheirPitchCostWhatAccuracySays) {
    // "higher by <= 4.3 % for sigma >= 1.2, 10 % at 0.8, 19 % at 0.6": 18.7 % where amplitude,
    // width and background are known, 22.3 % where the samples are so few that they matter.
    const auto over_closed = [](double width) {
        const SampledPulse pulse{.amplitude_dn = 200,
                                 .width = width,
                                 .half_aperture = 0.5,
                                 .background_dn = 0,
                                 .full_scale_dn = 1e9};
        return position_bound(pulse, additive(4)) /
               (std::sqrt(2 / std::sqrt(M_PI)) * std::sqrt(width) * 4 / 200);
    };
    EXPECT_LT(over_closed(1.2), 1.045);
    EXPECT_NEAR(over_closed(0.8), 1.10, 0.01);
    EXPECT_NEAR(over_closed(0.6), 1.223, 0.003);
}

TEST(PulseBound, AgreesWithTheBoundOfTheStripeTests) {
    // Written there independently: std::erf, central differences, Gauss-Jordan.
    std::mt19937 rng(3);
    std::uniform_real_distribution<double> u(0, 1);
    for (int i = 0; i < 200; ++i) {
        const SampledPulse pulse{.amplitude_dn = 20 + 200 * u(rng),
                                 .width = 0.7 + 3 * u(rng),
                                 .half_aperture = 0.1 + 0.4 * u(rng),
                                 .background_dn = 30 * u(rng),
                                 .full_scale_dn = 1e9};
        const SensorNoise noise{.gain_e_per_dn = 5 + 40 * u(rng), .read_noise_e = 20 * u(rng)};
        double squares = 0;
        for (int phase = 0; phase < 8; ++phase) {
            std::vector<double> x;
            const int reach = static_cast<int>(6 * pulse.width) + 4;
            for (int k = -reach; k <= reach; ++k) x.push_back(k + (phase + 0.5) / 8);
            squares += std::pow(
                test::cramer_rao_bound({pulse.amplitude_dn, 0, pulse.width, pulse.background_dn}, x,
                                       pulse.half_aperture, noise),
                2);
        }
        const double expected = std::sqrt(squares / 8);
        EXPECT_NEAR(position_bound(pulse, noise) / expected, 1, 2e-3)
            << pulse.width << " " << pulse.half_aperture;  // the windows end differently
    }
}

TEST(PulseBound, ClippedSamplesSayOnlyThatTheyAre) {
    SampledPulse pulse{.amplitude_dn = 400,
                       .width = 2,
                       .half_aperture = 0.4,
                       .background_dn = 5,
                       .full_scale_dn = 1e9};
    const SensorNoise noise{.gain_e_per_dn = 40, .read_noise_e = 8};
    double last = position_bound(pulse, noise);
    for (const double full_scale : {380.0, 255.0, 100.0}) {
        pulse.full_scale_dn = full_scale;
        const double bound = position_bound(pulse, noise);
        EXPECT_GT(bound, last) << full_scale;
        last = bound;
        double squares = 0;
        for (int phase = 0; phase < 8; ++phase) {
            std::vector<double> x;
            for (int k = -16; k <= 16; ++k) x.push_back(k + (phase + 0.5) / 8);
            squares += std::pow(
                test::cramer_rao_bound({400, 0, 2, 5}, x, 0.4, noise, full_scale - 0.5), 2);
        }
        EXPECT_NEAR(bound / std::sqrt(squares / 8), 1, 2e-3) << full_scale;
    }
    pulse.background_dn = 500;  // all of them
    EXPECT_TRUE(std::isinf(position_bound(pulse, noise)));
}

TEST(PulseBound, SnrOfAWidePulseIsAmplitudeOverNoise) {
    const SampledPulse pulse{.amplitude_dn = 100,
                             .width = 50,
                             .half_aperture = 0.5,
                             .background_dn = 20,
                             .full_scale_dn = 255};
    const SensorNoise noise{.gain_e_per_dn = 40, .read_noise_e = 8, .black_dn = 4};
    const double variance = (100 + 20 - 4) / 40.0 + 0.04 + 1.0 / 12;
    EXPECT_NEAR(peak_snr(pulse, noise), 100 / std::sqrt(variance), 0.01);
}

}  // namespace
}  // namespace stria

#include "firmware/stripe/deconvolution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <utility>
#include <vector>

#include "firmware/stripe/spacetime.h"
#include "tests/firmware/stripe/reflectance_card.h"

namespace stria {
namespace {

using test::ReflectanceCard;

double sum(std::span<const float> half) {
    double all = half[0];
    for (std::size_t n = 1; n < half.size(); ++n) all += 2 * half[n];
    return all;
}

/// Response of half a symmetric filter at w radians per px.
double response(std::span<const float> half, double w) {
    double all = half[0];
    for (std::size_t n = 1; n < half.size(); ++n)
        all += 2 * half[n] * std::cos(w * static_cast<double>(n));
    return all;
}

TEST(Deconvolution, FilterTurnsOneGaussianIntoANarrowerOne) {
    for (const auto& [footprint, target] :
         {std::pair{0.6, 0.4}, std::pair{0.8, 0.55}, std::pair{1.2, 1.0}}) {
        const RowDeconvolver filter({footprint, target}, 8);
        EXPECT_NEAR(sum(filter.taps()), 1, 1e-6);
        for (const double w : {0.2, 0.7, 1.5, 2.5}) {
            const double blurred = std::exp(-0.5 * footprint * footprint * w * w);
            EXPECT_NEAR(blurred * response(filter.taps(), w),
                        std::exp(-0.5 * target * target * w * w), 3e-3)
                << footprint << " " << target << " " << w;
        }
    }
}

TEST(Deconvolution, NoiseGainIsThatOfWhiteNoise) {
    const RowDeconvolver filter({0.8, 0.55}, 12);
    Frame frame;
    resize(frame, 4000, 30, 12);
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, 20);
    auto* samples = reinterpret_cast<std::uint16_t*>(frame.bytes.data());
    for (int i = 0; i < 4000 * 30; ++i)
        samples[i] = static_cast<std::uint16_t>(std::lround(2000 + noise(random)));
    const Frame out = filter(frame);
    double mean = 0, square = 0;
    for (int i = 0; i < 4000 * 30; ++i) mean += out.view16().at(i % 4000, i / 4000);
    mean /= 4000 * 30;
    for (int i = 0; i < 4000 * 30; ++i)
        square += std::pow(out.view16().at(i % 4000, i / 4000) - mean, 2);
    const double deviation = std::sqrt(square / (4000 * 30)) / filter.scale();
    EXPECT_NEAR(deviation / 20, filter.noise_gain(), 0.02 * filter.noise_gain());
    EXPECT_GT(filter.noise_gain(), 1);
    // No light and full scale keep their places.
    const SensorNoise noise_out = filter.noise_of({.gain_e_per_dn = 10, .read_noise_e = 200});
    EXPECT_NEAR(mean, noise_out.black_dn + filter.scale() * 2000, 4 * 20 * filter.scale() / 346);
    EXPECT_NEAR(std::sqrt(sample_variance(noise_out, noise_out.black_dn)),
                filter.scale() * filter.noise_gain() * 20, 0.01 * filter.scale() * 20);
}

TEST(Deconvolution, ClippedSamplesStayClippedAndNoOthers) {
    Frame frame;
    resize(frame, 40, 1, 8);
    for (int x = 0; x < 40; ++x) frame.bytes[static_cast<std::size_t>(x)] = x == 20 ? 255 : 254;
    const Frame out = RowDeconvolver({0.8, 0.55}, 8)(frame);
    for (int x = 0; x < 40; ++x) EXPECT_EQ(out.sample(x, 0) == 65535, x == 20);
}

/// Frames of a card, filtered.
std::vector<Frame> sharpened(const ReflectanceCard& card, const RowDeconvolver& filter) {
    std::vector<Frame> frames;
    for (int k = 0; k < card.frames(); ++k) frames.push_back(filter(card.frame(k)));
    return frames;
}

TEST(Deconvolution, CutsTheErrorAtReflectanceEdges) {
    // The greatest error over time is footprint / beam of the spatial moment's; what is left of the
    // footprint decides: 0.55 / 6.15 = 0.089 instead of 0.13.
    const RowDeconvolver filter({0.8, 0.55}, 16);
    const SensorNoise noise = filter.noise_of({.gain_e_per_dn = 1e9, .read_noise_e = 30e9});
    for (const double contrast : {2.0, 10.0}) {
        const ReflectanceCard card{.contrast = contrast, .beam_width = 6.15, .footprint = 0.8};
        const double spatial = test::greatest_shift(contrast) * card.beam_width;
        test::CardErrors sharp;
        test::measure_spacetime(card, sharpened(card, filter), noise, sharp);
        std::printf("K %4.0f: %.4f of the spatial moment's error, noise times %.2f\n", contrast,
                    sharp.spacetime / spatial, filter.noise_gain());
        EXPECT_EQ(sharp.pulses, sharp.pixels);
        EXPECT_LE(sharp.spacetime, 0.10 * spatial);
        EXPECT_NEAR(sharp.spacetime / spatial, 0.55 / 6.15, 0.05 * 0.55 / 6.15);
    }
}

TEST(Deconvolution, SigmaStaysHonest) {
    // One stripe over time in every pixel of a row; noise of 400 DN at a height of 12000.
    const ReflectanceCard card{.contrast = 1, .beam_width = 4, .footprint = 0.8};
    const SensorNoise sensor{.gain_e_per_dn = 1e9, .read_noise_e = 400e9};
    const RowDeconvolver filter({0.8, 0.55}, 16);
    double squares = 0;
    std::size_t count = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        std::mt19937 random(seed);
        std::normal_distribution<double> noise(0, 400);
        SpacetimeAnalyser analyser(card.width(), ReflectanceCard::kRows, 16,
                                   filter.noise_of(sensor));
        for (int k = 0; k < card.frames(); ++k) {
            Frame frame = card.frame(k);
            auto* samples = reinterpret_cast<std::uint16_t*>(frame.bytes.data());
            for (std::size_t i = 0; i < frame.bytes.size() / 2; ++i)
                samples[i] = static_cast<std::uint16_t>(
                    std::lround(4000 + 0.4 * samples[i] + noise(random)));
            analyser.add(filter(frame));
        }
        for (const Pulse& p : analyser.finish().pulses) {
            if (p.u < 12 || p.u > static_cast<float>(card.width() - 12)) continue;
            const double off = card.beam_at_time(p.t_ns) - static_cast<double>(p.u);
            const double sigma =
                p.sigma / static_cast<double>(ReflectanceCard::kPeriodNs) * card.beam_step;
            squares += std::pow(off / sigma, 2);
            ++count;
        }
    }
    ASSERT_GT(count, 300U);
    std::printf("sigma ratio %.3f of %zu\n", std::sqrt(squares / static_cast<double>(count)),
                count);
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(count)), 1.0, 0.1);
}

TEST(Deconvolution, BadOptionsAreRefused) {
    EXPECT_THROW(RowDeconvolver({0.1, 0.05}, 8), std::invalid_argument);
    EXPECT_THROW(RowDeconvolver({std::nan(""), 0.5}, 8), std::invalid_argument);
    EXPECT_THROW(RowDeconvolver({0.8, 0.8}, 8), std::invalid_argument);
    EXPECT_THROW(RowDeconvolver({2.0, 0.4}, 8), std::invalid_argument);  // noise times millions
    EXPECT_THROW(RowDeconvolver({0.8, 0.55}, 7), std::invalid_argument);
    Frame frame;
    resize(frame, 20, 2, 8);
    EXPECT_THROW(RowDeconvolver({0.8, 1e-3}, 10)(frame), std::invalid_argument);
}

}  // namespace
}  // namespace stria

#include "host/scan/clock_delay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "host/scan/merge_passes.h"
#include "tests/host/scan/pulse_maps.h"

namespace stria {
namespace {

using test_maps::kRate;
using test_maps::kSide;
using test_maps::map_of;
using test_maps::pulse_at;

/// Passes there and back whose stamps are `delay_s` early.
std::vector<PulseMap> there_and_back(double delay_s, double noise_s) {
    std::mt19937 random(9);
    std::normal_distribution<double> noise(0, noise_s);
    std::vector<PulseMap> passes;
    for (const double rate : {kRate, -0.8 * kRate})
        passes.push_back(map_of([&](int x, int y) {
            return std::vector{
                pulse_at(x, y, 0.1 + 1e-4 * x - rate * delay_s + noise(random), 1e-5, rate)};
        }));
    return passes;
}

TEST(ClockDelay, IsFoundFromTwoDirectionsWithATrueSigma) {
    const auto passes = there_and_back(40e-6, 1e-5);
    const auto delay = clock_delay(passes);
    ASSERT_TRUE(delay);
    EXPECT_EQ(delay->cells, std::size_t{kSide} * kSide);
    EXPECT_NEAR(delay->delay_ns, 40e3, 4 * delay->sigma_ns);
    // sqrt(2) x 1e-5 / 0.9 of a difference, times 1.25 / sqrt(1600) of the median
    EXPECT_NEAR(delay->sigma_ns, 1e9 * std::sqrt(2.0) * 1e-5 / 0.9 * 1.2533 / 40, 60);
    std::vector<PulseMap> corrected = passes;
    for (PulseMap& map : corrected) apply_delay(map, delay->delay_ns);
    EXPECT_NEAR(clock_delay(corrected)->delay_ns, 0, 1);
    EXPECT_EQ(merge_passes(corrected, PassGrid::image, "scan").pulses.size(),
              std::size_t{kSide} * kSide);
    EXPECT_GT(merge_passes(passes, PassGrid::image, "scan").pulses.size(),
              std::size_t{kSide} * kSide);
}

TEST(ClockDelay, NeedsTwoDirectionsAndEnoughCells) {
    std::vector<PulseMap> passes = there_and_back(40e-6, 1e-5);
    EXPECT_FALSE(clock_delay(std::span(passes).first(1)));
    passes[1] = passes[0];
    EXPECT_FALSE(clock_delay(passes));
    EXPECT_FALSE(clock_delay({}));
}

/// Peaks in rows over passes there and back, the stripe's column `column(row, true position)`.
template <typename Column>
std::vector<PulseMap> peaks_there_and_back(double delay_s, double noise_px, unsigned seed,
                                           Column column, double axis_noise = 0) {
    constexpr int kFrames = 300, kRows = 20;
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, noise_px);
    std::normal_distribution<double> unit(0, 1);
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<PulseMap> passes;
    for (const double rate : {20.0, -17.0}) {  // mm/s; frames of 5 ms
        PulseMap map;
        map.mode = StripeMode::spatial;
        map.width = kFrames;
        map.height = kRows;
        std::vector<double> trembles;
        for (int k = 0; k < kFrames; ++k) trembles.push_back(axis_noise * unit(random));
        for (int row = 0; row < kRows; ++row)
            for (int k = 0; k < kFrames; ++k) {
                map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
                if (share(random) < 0.05) continue;  // not every row shows the stripe
                const double s = (rate > 0 ? 0 : 30) + rate * 0.005 * k;
                const bool is_stray = share(random) < 0.02;
                const double u =
                    column(row, s + rate * delay_s + trembles[static_cast<std::size_t>(k)]) +
                    noise(random) + (is_stray ? 40 * share(random) : 0);
                Pulse peak = pulse_at(0, row, s, 1e-5, rate);
                peak.u = static_cast<float>(u);
                peak.sigma = static_cast<float>(noise_px);
                map.pulses.push_back(peak);
            }
        map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
        passes.push_back(map);
    }
    return passes;
}

double hills(int row, double s) { return 300 + 12 * std::sin(0.5 * s + 0.3 * row) + 0.02 * s * s; }

TEST(ClockDelay, OfPeaksIsFoundWithATrueSigma) {
    constexpr int kTrials = 100;
    // -20 ms are four frames; in the last the axis trembles by 0.01 mm, half a ms.
    for (const auto& [delay_s, axis_noise] :
         std::vector<std::pair<double, double>>{{0, 0}, {300e-6, 0}, {-20e-3, 0}, {300e-6, 0.01}}) {
        double squares = 0, sum = 0;
        for (unsigned seed = 1; seed <= kTrials; ++seed) {
            const auto delay =
                clock_delay(peaks_there_and_back(delay_s, 0.1, seed, hills, axis_noise));
            ASSERT_TRUE(delay);
            const double off = (delay->delay_ns - 1e9 * delay_s) / delay->sigma_ns;
            sum += off;
            squares += off * off;
            if (seed == 1)
                std::printf("%.1f us: %.1f +- %.1f us from %zu places\n", 1e6 * delay_s,
                            1e-3 * delay->delay_ns, 1e-3 * delay->sigma_ns, delay->cells);
        }
        std::printf("mean %.2f, rms %.2f sigma\n", sum / kTrials, std::sqrt(squares / kTrials));
        EXPECT_LT(std::abs(sum / kTrials), 0.4);  // 4 sigma of a mean of 100
        EXPECT_GT(std::sqrt(squares / kTrials), 0.75);
        EXPECT_LT(std::sqrt(squares / kTrials), 1.25);
    }
}

TEST(ClockDelay, WithoutNoiseIsExact) {
    const auto delay = clock_delay(peaks_there_and_back(300e-6, 0, 1, hills));
    ASSERT_TRUE(delay);
    EXPECT_NEAR(delay->delay_ns, 300e3, 500);  // columns are floats: 3e-5 px
    EXPECT_GE(delay->sigma_ns, 1);
    const ClockDelay both[] = {*delay, *delay};
    EXPECT_NEAR(mean_of(both).delay_ns, delay->delay_ns, 1e-6);
}

TEST(ClockDelay, AxisThatDoesNotMoveTellsNothing) {
    std::vector<PulseMap> passes = peaks_there_and_back(300e-6, 0.1, 1, hills);
    for (PulseMap& map : passes)
        for (Pulse& peak : map.pulses) peak.s = 10;
    EXPECT_FALSE(clock_delay(passes));
}

TEST(ClockDelay, AStripeThatStaysWhereItIsTellsNothing) {
    const auto flat = [](int row, double) { return 300.0 + row; };
    const auto delay = clock_delay(peaks_there_and_back(5e-3, 0.1, 3, flat));
    EXPECT_TRUE(!delay || std::abs(delay->delay_ns) < 4 * delay->sigma_ns);
    std::vector<PulseMap> one_way = peaks_there_and_back(5e-3, 0.1, 3, hills);
    one_way[1] = one_way[0];
    EXPECT_FALSE(clock_delay(one_way));
}

}  // namespace
}  // namespace stria

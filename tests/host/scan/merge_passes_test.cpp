#include "host/scan/merge_passes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kRate = 0.5;  // rad/s
constexpr int kSide = 40;

Pulse pulse_at(int x, int y, double s, double sigma_s, double rate = kRate) {
    Pulse pulse;
    pulse.u = static_cast<float>(x);
    pulse.v = static_cast<float>(y);
    pulse.s = s;
    pulse.ds_dt = rate;
    pulse.sigma = static_cast<float>(sigma_s / std::abs(rate) * 1e9);
    pulse.amplitude = 100;
    return pulse;
}

double sigma_of_s(const Pulse& pulse) {
    return static_cast<double>(pulse.sigma) * 1e-9 * std::abs(pulse.ds_dt);
}

/// A map of kSide x kSide cells from `of_cell(x, y)`, which gives the pulses of a cell.
template <typename OfCell>
PulseMap map_of(OfCell of_cell) {
    PulseMap map;
    map.width = map.height = kSide;
    map.frames = 10;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
            for (const Pulse& pulse : of_cell(x, y)) map.pulses.push_back(pulse);
        }
    map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
    return map;
}

TEST(MergePasses, ThePlaceIsTheWeightedMeanAndItsSigmaIsTrue) {
    // Three passes of standard deviations 1, 2 and 4: 1 / sqrt(1 + 1/4 + 1/16) = 0.873.
    std::mt19937 random(4);
    std::normal_distribution<double> noise;
    std::vector<PulseMap> passes;
    for (const double sigma : {1e-5, 2e-5, 4e-5})
        passes.push_back(map_of([&](int x, int y) {
            return std::vector{pulse_at(x, y, 0.1 + sigma * noise(random), sigma)};
        }));
    const PulseMap merged = merge_passes(passes, PassGrid::image, "scan");
    ASSERT_TRUE(is_valid(merged));
    EXPECT_EQ(merged.frames, 30U);
    double squares = 0;
    std::size_t one = 0;
    for (std::size_t cell = 0; cell + 1 < merged.cell_begin.size(); ++cell) {
        if (merged.cell_begin[cell + 1] != merged.cell_begin[cell] + 1) continue;
        const Pulse& pulse = merged.pulses[merged.cell_begin[cell]];
        EXPECT_NEAR(sigma_of_s(pulse), 0.8729e-5, 1e-9);
        squares += std::pow((pulse.s - 0.1) / sigma_of_s(pulse), 2);
        ++one;
    }
    EXPECT_GT(one, kSide * kSide - 5U);  // four standard deviations apart: 6e-5 of the cells
    // 1600 cells: sqrt(chi-square / n) has a standard deviation of 0.018.
    EXPECT_NEAR(std::sqrt(squares / static_cast<double>(one)), 1, 0.06);
}

TEST(MergePasses, OtherPlacesAndLasersStayApart) {
    const PulseMap a = map_of([](int x, int y) {
        return std::vector{pulse_at(x, y, 0.1, 1e-5), pulse_at(x, y, 0.2, 1e-5)};
    });
    const PulseMap b = map_of([](int x, int y) {
        Pulse other = pulse_at(x, y, 0.1, 1e-5);
        other.laser_id = 1;
        return std::vector{pulse_at(x, y, 0.20001, 1e-5), other};
    });
    const std::vector<PulseMap> passes = {a, b};
    const PulseMap merged = merge_passes(passes, PassGrid::image, "scan");
    for (std::size_t cell = 0; cell + 1 < merged.cell_begin.size(); ++cell)
        EXPECT_EQ(merged.cell_begin[cell + 1] - merged.cell_begin[cell], 3U);
}

TEST(MergePasses, AClippedPulseKeepsToItsOwnWeight) {
    const PulseMap clipped = map_of([](int x, int y) {
        Pulse pulse = pulse_at(x, y, 0.10002, 1e-5);
        pulse.flags = kPulseSaturated;
        pulse.amplitude = 255;
        return std::vector{pulse};
    });
    const PulseMap clean =
        map_of([](int x, int y) { return std::vector{pulse_at(x, y, 0.1, 0.5e-5)}; });
    const std::vector<PulseMap> passes = {clipped, clean};
    const Pulse pulse = merge_passes(passes, PassGrid::image, "scan").pulses[7];
    EXPECT_EQ(pulse.flags, 0);
    EXPECT_NEAR(pulse.s, 0.1 + 0.00002 / 5, 1e-9);
}

TEST(MergePasses, FillsWhatOnePassMissesAndKeepsOneAsItIs) {
    const PulseMap left = map_of([](int x, int y) {
        return x < kSide / 2 ? std::vector{pulse_at(x, y, 0.1, 1e-5)} : std::vector<Pulse>{};
    });
    const PulseMap right = map_of([](int x, int y) {
        return x < kSide / 2 ? std::vector<Pulse>{} : std::vector{pulse_at(x, y, 0.1, 1e-5)};
    });
    const std::vector<PulseMap> both = {left, right};
    EXPECT_EQ(merge_passes(both, PassGrid::image, "scan").pulses.size(),
              std::size_t{kSide} * kSide);
    const std::vector<PulseMap> one = {left};
    EXPECT_EQ(merge_passes(one, PassGrid::image, "scan").pulses.size(), left.pulses.size());
}

TEST(MergePasses, GridsMustBeTheSame) {
    std::vector<PulseMap> passes(
        2, map_of([](int x, int y) { return std::vector{pulse_at(x, y, 0.1, 1e-5)}; }));
    passes[1].height = 1;
    EXPECT_THROW(merge_passes(passes, PassGrid::image, "scan"), Error);
}

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

}  // namespace
}  // namespace stria

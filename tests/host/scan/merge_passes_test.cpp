#include "host/scan/merge_passes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "host/core/errors.h"
#include "tests/host/scan/pulse_maps.h"

namespace stria {
namespace {

using test_maps::kSide;
using test_maps::map_of;
using test_maps::pulse_at;

double sigma_of_s(const Pulse& pulse) {
    return static_cast<double>(pulse.sigma) * 1e-9 * std::abs(pulse.ds_dt);
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

}  // namespace
}  // namespace stria

#include "host/scan/compare_directions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "host/scan/merge_passes.h"

namespace stria {
namespace {

constexpr double kRate = 0.5;    // rad/s
constexpr double kWidth = 1e-3;  // rad, of a pulse
constexpr double kSigma = 1e-5;  // rad
constexpr int kSide = 100;
constexpr DirectionOptions kSweep = {.from = 0, .to = 0.2, .noise = {}};

struct Light {
    double s = 0;
    float amplitude = 100;
    std::uint16_t flags = 0;
};

/// Two passes of the same scene, the second one backwards, with Gaussian noise of kSigma each and
/// `trembling` besides.
class Sweep {
  public:
    explicit Sweep(double trembling = 0, unsigned seed = 5) : random_(seed) {
        for (PulseMap& pass : passes) {
            pass.width = pass.height = kSide;
            pass.frames = 100;
        }
        for (int cell = 0; cell < kSide * kSide; ++cell)
            add(cell, {still(cell)}, {still(cell)}, trembling);
    }
    static Light still(int cell) { return {0.05 + 1e-3 * (cell % kSide)}; }

    /// Ends the cells; the last call for a cell counts.
    void add(int cell, std::vector<Light> there, std::vector<Light> back, double trembling = 0) {
        const std::size_t at = static_cast<std::size_t>(cell);
        for (std::size_t pass = 0; pass < 2; ++pass) {
            std::vector<Pulse> pulses;
            for (const Light& light : pass == 0 ? there : back) {
                Pulse pulse;
                pulse.u = static_cast<float>(cell % kSide);
                pulse.v = static_cast<float>(cell / kSide);
                pulse.s = light.s + std::hypot(kSigma, trembling) * noise_(random_);
                pulse.ds_dt = pass == 0 ? kRate : -kRate;
                pulse.sigma = static_cast<float>(kSigma / kRate * 1e9);
                pulse.width = static_cast<float>(kWidth / kRate * 1e9);
                pulse.amplitude = light.amplitude;
                pulse.flags = light.flags;
                pulses.push_back(pulse);
            }
            cells_[pass].resize(std::max(cells_[pass].size(), at + 1));
            cells_[pass][at] = pulses;
        }
    }
    std::optional<DirectionComparison> compare(const DirectionOptions& options = kSweep) {
        for (std::size_t pass = 0; pass < 2; ++pass) {
            PulseMap& map = passes[pass];
            map.pulses.clear();
            map.cell_begin.assign(1, 0);
            for (const auto& cell : cells_[pass]) {
                map.pulses.insert(map.pulses.end(), cell.begin(), cell.end());
                map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
            }
        }
        return compare_directions(passes, options);
    }
    /// Flags of a cell's pulses, there and back.
    std::vector<int> flags(int cell) const {
        std::vector<int> flags;
        for (const PulseMap& pass : passes)
            for (const Pulse& pulse : pass.cell(cell % kSide, cell / kSide))
                flags.push_back(pulse.flags);
        return flags;
    }

    std::vector<PulseMap> passes = std::vector<PulseMap>(2);

  private:
    std::mt19937 random_;
    std::normal_distribution<double> noise_;
    std::vector<std::vector<Pulse>> cells_[2];
};

using Flags = std::vector<int>;
constexpr int kGhost = kPulseGhostSuspected;
constexpr int kCell = 4321;

TEST(CompareDirections, AStillSceneLosesNothing) {
    // Of 50 000 pairs of Gaussian noise 0.05 are beyond 4.9 standard deviations: none is, but once
    // in 20 seeds, and that one flags two pulses.
    std::size_t pairs = 0, flagged = 0;
    for (unsigned seed = 1; seed <= 5; ++seed) {
        Sweep still(0, seed);
        const auto told = still.compare();
        ASSERT_TRUE(told);
        pairs += kSide * kSide;
        flagged += told->flagged();
        EXPECT_EQ(told->agreeing + told->flagged() + told->untold, 2U * kSide * kSide);
        EXPECT_LT(told->axis_sigma_s, 0.25 * kSigma);  // sqrt(2 x 0.012) of the median's scatter
    }
    EXPECT_LE(flagged, 2U) << pairs << " pairs";
}

TEST(CompareDirections, WhatTheAxisTremblesByIsMeasuredAndAllowed) {
    Sweep sweep(4 * kSigma);
    const auto told = sweep.compare();
    ASSERT_TRUE(told);
    EXPECT_NEAR(told->axis_sigma_s, 4 * kSigma, 0.1 * kSigma);  // 1.2 % of a median over 1e4 pairs
    EXPECT_EQ(told->flagged(), 0U);
    const PulseMap merged = merge_passes(sweep.passes, PassGrid::image, "scan", told->axis_sigma_s);
    EXPECT_EQ(merged.pulses.size(), std::size_t{kSide} * kSide);
}

TEST(CompareDirections, APulseOfOneDirectionOnlyIsFlagged) {
    Sweep sweep;
    const Light here = Sweep::still(kCell);
    sweep.add(kCell, {here, {0.16}}, {here});
    sweep.add(kCell + 1, {}, {here});
    const auto told = sweep.compare();
    ASSERT_TRUE(told);
    EXPECT_EQ(told->unseen, 2U);
    EXPECT_EQ(sweep.flags(kCell), (Flags{0, kGhost, 0}));
    EXPECT_EQ(sweep.flags(kCell + 1), (Flags{kGhost}));
    const PulseMap merged = merge_passes(sweep.passes, PassGrid::image, "scan");
    EXPECT_EQ(merged.cell(kCell % kSide, kCell / kSide)[1].flags, kGhost);
}

TEST(CompareDirections, BesideWhatIsDeniedNothingCountsThatIsNotConfirmed) {
    // On the way back something weak hides the surface: neither is to be trusted.
    Sweep sweep;
    sweep.add(kCell, {{0.1}}, {{0.15, 4}});
    const auto told = sweep.compare();
    ASSERT_TRUE(told);
    EXPECT_EQ(told->unseen, 1U);
    EXPECT_EQ(told->beside, 1U);
    EXPECT_EQ(sweep.flags(kCell), (Flags{kGhost, kGhost}));
}

TEST(CompareDirections, WhatStandsElsewhereOnTheWayBackIsFlaggedInBoth) {
    Sweep sweep;
    sweep.add(kCell, {{0.1}}, {{0.1 + 0.2 * kWidth}});
    sweep.add(kCell + 1, {{0.1}}, {{0.1 + 10 * kWidth}});
    const auto told = sweep.compare();
    ASSERT_TRUE(told);
    EXPECT_EQ(told->displaced, 2U);
    EXPECT_EQ(told->unseen, 2U);
    EXPECT_EQ(sweep.flags(kCell), (Flags{kGhost, kGhost}));
    EXPECT_EQ(sweep.flags(kCell + 1), (Flags{kGhost, kGhost}));
}

TEST(CompareDirections, ASuspicionByStrengthAloneIsTakenBack) {
    Sweep sweep;
    sweep.add(kCell, {{0.1}, {0.15, 30, kGhost}}, {{0.1}, {0.15, 30, kGhost}});
    ASSERT_TRUE(sweep.compare());
    EXPECT_EQ(sweep.flags(kCell), (Flags{0, 0, 0, 0}));
}

TEST(CompareDirections, NothingFollowsWhereTheOtherDirectionNeedNotHaveSeenIt) {
    Sweep sweep;
    const std::vector<std::pair<std::vector<Light>, std::vector<Light>>> cells = {
        {{{0.1, 5}}, {}},                                     // below min_amplitude_dn
        {{{0.001}}, {}},                                      // its flank began before the sweep
        {{{0.199}}, {}},                                      // or goes on behind it
        {{{0.1, 100, kPulseWidthOutOfRange}}, {}},            // doubted as it is
        {{{0.1}}, {{0.1 + kWidth, 100, kPulseOverlapping}}},  // two that ran together
        {{{0.1}, {0.05, 90}}, {{0.05, 90}, {0.15, 90}}},      // a third one is not kept
    };
    for (std::size_t i = 0; i < cells.size(); ++i)
        sweep.add(kCell + static_cast<int>(i), cells[i].first, cells[i].second);
    const auto told = sweep.compare();
    ASSERT_TRUE(told);
    for (std::size_t i = 0; i < cells.size(); ++i)
        EXPECT_EQ(sweep.flags(kCell + static_cast<int>(i))[0] & kGhost, 0) << i;
}

TEST(CompareDirections, LostFramesExcuseWhatTheyHeld) {
    // The way back lost its frames from s = 0.06 to 0.07: ten columns of pulses.
    Sweep sweep;
    for (int cell = 0; cell < kSide * kSide; ++cell) {
        const Light light = Sweep::still(cell);
        if (light.s > 0.0605 && light.s < 0.0705) sweep.add(cell, {light}, {});
    }
    const int alone = 5 * kSide + 60;
    sweep.add(alone, {Sweep::still(alone)}, {});
    sweep.passes[1].frames_dropped = 10;
    const auto told = sweep.compare();
    ASSERT_TRUE(told);
    EXPECT_EQ(told->unseen, 1U);
    EXPECT_EQ(sweep.flags(alone), (Flags{kGhost}));
    EXPECT_EQ(told->untold, 10U * kSide);
}

TEST(CompareDirections, AnyExposureConfirmsOnlyTheSameOneDenies) {
    // A second exposure goes there and back as well; what it shows confirms the first one's pulses,
    // but that a dark exposure shows nothing is no wonder.
    Sweep sweep;
    sweep.add(kCell, {{0.16}}, {});
    ASSERT_TRUE(sweep.compare());
    std::vector<PulseMap> passes = sweep.passes;
    passes[1].pulses.clear();
    passes[1].cell_begin.assign(passes[1].cell_begin.size(), 0);
    passes.push_back(sweep.passes[1]);
    for (Pulse& pulse : passes[2].pulses) pulse.exposure_index = 1;
    const auto told = compare_directions(passes, kSweep);
    ASSERT_TRUE(told);
    EXPECT_EQ(told->flagged(), 0U);
    EXPECT_EQ(told->agreeing, 2U * (kSide * kSide - 1));
}

TEST(CompareDirections, NeedsTwoDirectionsOfOneLaser) {
    Sweep sweep;
    ASSERT_TRUE(sweep.compare());
    EXPECT_FALSE(compare_directions(std::span(sweep.passes).first(1), kSweep));
    std::vector<PulseMap> same = {sweep.passes[0], sweep.passes[0]};
    EXPECT_FALSE(compare_directions(same, kSweep));
    std::vector<PulseMap> lasers = sweep.passes;
    for (Pulse& pulse : lasers[1].pulses) pulse.laser_id = 1;
    EXPECT_FALSE(compare_directions(lasers, kSweep));
    EXPECT_FALSE(compare_directions({}, kSweep));
}

}  // namespace
}  // namespace stria

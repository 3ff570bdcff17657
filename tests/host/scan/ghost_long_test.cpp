#include <gtest/gtest.h>

#include <cstdio>

#include "tests/host/scan/ghost_trials.h"

namespace stria::test {
namespace {

constexpr double kRight = 0.99;  // of the lit pixels whose ghost stands apart
constexpr double kWrong = 1e-4;  // of the points without warnings
constexpr std::size_t kFewest = 100000;

void expect_ghosts_told(const char* name, const Scene& scene, unsigned seed) {
    const GhostScan scan = scan_ghosts(scene, seed);
    const GhostCount& c = scan.count;
    std::printf(
        "%-16s lit %zu, right pulse chosen %.4f, without a warning %.4f; points %zu, wrong %zu "
        "(%.1e); flagged %zu; several pulses %zu, turned away %zu, ambiguous %zu, near merging "
        "%zu\n",
        name, c.lit, c.chosen_share(), c.right_share(), c.points, c.wrong,
        static_cast<double>(c.wrong) / static_cast<double>(c.points), c.flagged, c.several,
        scan.statistics.turned_away, scan.statistics.ambiguous, scan.statistics.near_merging);
    EXPECT_GE(c.points, kFewest);
    EXPECT_GE(c.chosen_share(), kRight);
    EXPECT_LE(static_cast<double>(c.wrong), kWrong * static_cast<double>(c.points));
}

TEST(GhostsLong, Groove60) { expect_ghosts_told("groove 60", groove_scene(60, 0.9, 800, 200), 1); }
TEST(GhostsLong, Groove80) { expect_ghosts_told("groove 80", groove_scene(80, 0.9, 800, 200), 2); }
TEST(GhostsLong, Groove90) { expect_ghosts_told("groove 90", groove_scene(90, 0.9, 800, 200), 3); }
TEST(GhostsLong, Groove80Grey) {
    expect_ghosts_told("groove 80, grey", groove_scene(80, 0.5, 800, 200), 4);
}
TEST(GhostsLong, Mirror) { expect_ghosts_told("mirror", mirror_scene(560, 300), 5); }

}  // namespace
}  // namespace stria::test

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/host/scan/ghost_trials.h"

namespace stria::test {
namespace {

constexpr double kRight = 0.99;  // of the lit pixels whose ghost stands apart: right, no warning
constexpr double kWrong = 1e-4;  // of the points without warnings
constexpr std::size_t kFewest = 100000;

void expect_ghosts_told(const char* name, const Scene& scene, unsigned seed) {
    const GhostScan scan = scan_ghosts(scene, seed);
    const GhostCount& c = scan.count;
    std::printf(
        "%-26s lit %zu, close %zu, right pulse chosen %.4f, without a warning %.4f of those apart; "
        "points %zu, wrong %zu (%.1e), partly lit %zu of them; flagged %zu; several pulses %zu, "
        "turned away "
        "%zu, ambiguous %zu, near merging %zu\n",
        name, c.lit, c.close, c.chosen_share(), c.right_share(), c.points, c.wrong,
        static_cast<double>(c.wrong) / static_cast<double>(c.points), c.wrong_partly_lit, c.flagged,
        c.several, scan.statistics.turned_away, scan.statistics.ambiguous,
        scan.statistics.near_merging);
    EXPECT_GE(c.points, kFewest);
    EXPECT_GE(c.chosen_share(), kRight);
    EXPECT_GE(c.right_share(), kRight);
    EXPECT_LE(static_cast<double>(c.wrong), kWrong * static_cast<double>(c.points));
}

constexpr GhostScanner kMirrorScanner = {.width = 560, .height = 300};

// The scenes on which the thresholds of host/scan/judge_pulses were chosen.
TEST(GhostsChosenOn, Groove60) {
    expect_ghosts_told("groove 60", groove_scene({.degrees = 60}), 1);
}
TEST(GhostsChosenOn, Groove80) {
    expect_ghosts_told("groove 80", groove_scene({.degrees = 80}), 2);
}
TEST(GhostsChosenOn, Groove90) {
    expect_ghosts_told("groove 90", groove_scene({.degrees = 90}), 3);
}
TEST(GhostsChosenOn, Groove80Grey) {
    expect_ghosts_told("groove 80, grey", groove_scene({.degrees = 80, .albedo = 0.5}), 4);
}
TEST(GhostsChosenOn, Mirror) { expect_ghosts_told("mirror", mirror_scene({}, kMirrorScanner), 5); }
TEST(GhostsChosenOn, MirrorLeaningLaserOnTheLeft) {
    GhostScanner scanner = kMirrorScanner;
    scanner.laser_on_left = true;
    expect_ghosts_told(
        "mirror 6, left",
        mirror_scene({.reflectance = 0.6, .floor_albedo = 0.6, .lean_degrees = 6}, scanner), 6);
}

// Other angles, albedos, widths of the beam and sides of the camera, which no threshold has seen.
TEST(GhostsHeldOut, Groove70) {
    expect_ghosts_told("groove 70, white", groove_scene({.degrees = 70, .albedo = 0.95}), 11);
}
TEST(GhostsHeldOut, Groove100) {
    expect_ghosts_told("groove 100", groove_scene({.degrees = 100, .albedo = 0.8}), 12);
}
TEST(GhostsHeldOut, Groove75Turned) {
    expect_ghosts_told("groove 75 turned, grey",
                       groove_scene({.degrees = 75, .albedo = 0.6, .turned_degrees = 8}), 13);
}
TEST(GhostsHeldOut, Groove85LaserOnTheLeft) {
    expect_ghosts_told("groove 85 turned, left",
                       groove_scene({.degrees = 85, .albedo = 0.85, .turned_degrees = -6},
                                    {.laser_on_left = true}),
                       14);
}
TEST(GhostsHeldOut, Groove80NarrowBeam) {
    expect_ghosts_told("groove 80, beam 0.45 mm",
                       groove_scene({.degrees = 80, .albedo = 0.75}, {.beam_sigma_mm = 0.45}), 15);
}
TEST(GhostsHeldOut, Groove110WideBeamLaserOnTheLeft) {
    expect_ghosts_told(
        "groove 110, 0.8 mm, left",
        groove_scene({.degrees = 110}, {.beam_sigma_mm = 0.8, .laser_on_left = true}), 16);
}
TEST(GhostsHeldOut, MirrorLeaningOver) {
    GhostScanner scanner = kMirrorScanner;
    scanner.beam_sigma_mm = 0.5;
    expect_ghosts_told(
        "mirror -3, beam 0.5 mm",
        mirror_scene({.reflectance = 0.75, .floor_albedo = 0.9, .lean_degrees = -3}, scanner), 17);
}
TEST(GhostsHeldOut, MirrorLaserOnTheLeft) {
    GhostScanner scanner = kMirrorScanner;
    scanner.laser_on_left = true;
    expect_ghosts_told("mirror 2, left",
                       mirror_scene({.reflectance = 0.8, .lean_degrees = 2}, scanner), 18);
}

}  // namespace
}  // namespace stria::test

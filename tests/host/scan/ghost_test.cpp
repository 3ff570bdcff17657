#include <gtest/gtest.h>

#include "tests/host/scan/ghost_trials.h"

namespace stria::test {
namespace {

TEST(Ghosts, AGroovesInterReflectionNeverPassesForASurface) {
    const GhostScan scan =
        scan_ghosts(groove_scene({.degrees = 80}, {.width = 160, .height = 24}), 1);
    EXPECT_GT(scan.count.points, 3500u);
    EXPECT_EQ(scan.count.wrong, 0u);
    EXPECT_GT(scan.count.several, 300u) << "the bounce was not seen at all";
    EXPECT_GE(scan.count.chosen_share(), 0.95);  // of 160 pixels 4 lie in the crease itself
}

TEST(Ghosts, AMirrorsSecondStripeIsToldFromTheFirstOne) {
    const GhostScan scan = scan_ghosts(mirror_scene({}, {.width = 300, .height = 24}), 2);
    EXPECT_EQ(scan.count.wrong, 0u);
    EXPECT_GT(scan.statistics.turned_away, 1000u);
    EXPECT_GE(scan.count.chosen_share(), 0.98);  // of 279 lit columns 3 are the mirror's foot
}

TEST(Ghosts, PixelsThatAShadowsBorderCutsAreNotWrong) {
    // Of its 560 columns one is lit to a quarter, and was wrong in four rows of five.
    const GhostScan scan =
        scan_ghosts(mirror_scene({.reflectance = 0.6, .floor_albedo = 0.6, .lean_degrees = 6},
                                 {.width = 560, .height = 12, .laser_on_left = true}),
                    6);
    EXPECT_EQ(scan.count.wrong, 0u);
    EXPECT_GE(scan.statistics.partly_lit, 12u);
}

TEST(Ghosts, WithoutReflectionsNothingIsSuspected) {
    const GhostScan scan = scan_ghosts(plain_scene(300, 60), 3);
    EXPECT_EQ(scan.statistics.turned_away, 0u);
    EXPECT_LE(scan.count.flagged * 1000, scan.count.points);  // one in a thousand, on edges
}

}  // namespace
}  // namespace stria::test

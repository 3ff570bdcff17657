#include <gtest/gtest.h>

#include "tests/host/scan/direction_trials.h"
#include "tests/host/scan/ghost_trials.h"

namespace stria::test {
namespace {

constexpr int kWidth = 300, kHeight = 20;

/// The plain scene with a ball in front of its plate.
Scene with_ball(double x_mm) {
    Scene scene = plain_scene(kWidth, kHeight);
    SceneObject ball = scene.objects[0];
    ball.name = "intruder";
    ball.radius_mm = 8;
    ball.world_from_object.translation = {x_mm, 0, -400};
    scene.objects.push_back(ball);
    return scene;
}

TEST(Directions, AStillSceneLosesNoPoints) {
    const Scene plain = plain_scene(kWidth, kHeight);
    const Outcome of_plain =
        outcome_of(sweep(plain, 1, false), plain, sweep(plain, 2, true), plain);
    EXPECT_EQ(of_plain.told.flagged(), 0U);
    EXPECT_GT(of_plain.told.agreeing, 10000U);
    const Scene mirror = mirror_scene({}, {.width = 300, .height = 8});
    const Outcome of_mirror =
        outcome_of(sweep(mirror, 3, false), mirror, sweep(mirror, 4, true), mirror);
    EXPECT_EQ(of_mirror.told.flagged(), 0U);  // its ghosts stand still as well
    EXPECT_GT(of_mirror.told.agreeing, 4000U);
}

TEST(Directions, WhatWasThereInOneDirectionOnlyIsFlagged) {
    const Scene still = plain_scene(kWidth, kHeight);
    const Scene then = with_ball(12);
    const Outcome ball = outcome_of(sweep(still, 5, false), still, sweep(then, 6, true), then);
    EXPECT_GT(ball.wrong, 300U);
    EXPECT_EQ(ball.missed, 0U);
    EXPECT_EQ(ball.wrong_flagged, ball.wrong);
}

TEST(Directions, WhatMovedBetweenThemIsFlagged) {
    // 1 mm along the stripe's travel and 0.5 mm towards the scanner, the plate behind it still.
    const Scene first = with_ball(12);
    Scene then = first;
    then.objects.back().world_from_object.translation += Eigen::Vector3d(1, 0, 0.5);
    const Outcome moved = outcome_of(sweep(first, 7, false), first, sweep(then, 8, true), then);
    EXPECT_GT(moved.wrong, 300U);
    // Half-covered pixels on its rim, where the border's shift makes up for the motion.
    EXPECT_LE(static_cast<double>(moved.missed), 0.01 * static_cast<double>(moved.wrong));
    EXPECT_GE(moved.wrong_flagged_share(), 0.98);  // pulses too weak to be asked for, at its rim
}

TEST(Directions, AFlashDuringOneOfThemIsFlagged) {
    // Three frames of more light from all sides, the middle one the brightest: as long as the
    // sheet takes over a point.
    const Scene still = plain_scene(kWidth, kHeight);
    SimSweep there = sweep(still, 9, false);
    Scene bright = still, brighter = still;
    bright.ambient_level = 0.1;
    brighter.ambient_level = 0.2;
    const std::size_t at = there.frames.size() / 2;
    const SimSweep half = sweep(bright, 9, false), full = sweep(brighter, 9, false);
    there.frames[at - 1] = half.frames[at - 1];
    there.frames[at] = full.frames[at];
    there.frames[at + 1] = half.frames[at + 1];
    const Outcome flash = outcome_of(there, still, sweep(still, 10, true), still);
    EXPECT_GT(flash.told.unseen, 2000U);
    EXPECT_EQ(flash.wrong_flagged, flash.wrong);
    EXPECT_LE(flash.right_flagged_share(), 0.05);  // pulses that its light ran together with
}

}  // namespace
}  // namespace stria::test

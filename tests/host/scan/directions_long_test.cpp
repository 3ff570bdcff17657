#include <gtest/gtest.h>

#include "tests/host/scan/direction_trials.h"
#include "tests/host/scan/ghost_trials.h"

namespace stria::test {
namespace {

constexpr double kFalseAlarms = 1e-5;  // of the pulses of a still scene

void expect_no_false_alarms(const Scene& scene, unsigned seed) {
    const Outcome outcome =
        outcome_of(sweep(scene, seed, false), scene, sweep(scene, seed + 1, true), scene);
    EXPECT_GT(outcome.told.agreeing, 100000U);
    EXPECT_LE(static_cast<double>(outcome.told.flagged()),
              kFalseAlarms * static_cast<double>(outcome.told.agreeing));
}

TEST(DirectionsOfStillScenes, Plain) { expect_no_false_alarms(plain_scene(560, 420), 21); }
TEST(DirectionsOfStillScenes, Mirror) {
    expect_no_false_alarms(mirror_scene({}, {.width = 560, .height = 300}), 23);
}
TEST(DirectionsOfStillScenes, Groove) { expect_no_false_alarms(groove_scene({.degrees = 80}), 25); }

}  // namespace
}  // namespace stria::test

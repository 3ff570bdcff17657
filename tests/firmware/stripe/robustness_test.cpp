#include <gtest/gtest.h>

#include "tests/firmware/stripe/robustness_trials.h"

namespace stria::test {
namespace {

TEST(Robustness, DropsJitterAndAmbientLightKeepToTheBoundIn2000Trials) { expect_robust(2000); }

// The drops of the statistics above are few; here they are many.
TEST(Robustness, EveryLostFrameIsReported) {
    const RobustnessCell cell =
        measure_robustness({.name = "10 % dropped", .drop_probability = 0.1}, 2.5, 50, 4000, 77);
    EXPECT_GT(cell.frames_lost, 10);
    EXPECT_EQ(cell.frames_reported_lost, cell.frames_lost);
    EXPECT_GT(cell.hit.trials, 500);
    EXPECT_LE(cell.found.ratio(), 1.1 + 3 / std::sqrt(2.0 * cell.found.trials));
    EXPECT_GE(cell.found.found, 0.99);
}

}  // namespace
}  // namespace stria::test

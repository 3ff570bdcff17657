#include <gtest/gtest.h>

#include <cstdint>

#include "tests/firmware/stripe/fast_random_trials.h"

namespace stria::test {
namespace {

TEST(FastSpacetime, BreaksNoBoundInRandomSweeps) { expect_no_broken_bound(0, 300); }

// Among them a pulse whose flank fell between missing frames: its first step's matrix was 6 % off.
TEST(FastSpacetime, SigmaServesBesideMissingFrames) { expect_no_broken_bound(300'300, 300'400); }

// Among them a pulse of 1.8 frames whose samples jitter by half a frame: 8 % off.
TEST(FastSpacetime, SigmaServesAmongJitteringFrames) { expect_no_broken_bound(7'990, 8'000); }

// Among them a misfitting pulse that two places and widths between the frames explain alike.
TEST(FastSpacetime, LeavesTwoWaysBetweenSamplesToTheReference) {
    expect_no_broken_bound(98'480, 98'490);
}

// Among them pulses whose last steps still moved them by more than a tenth of their sigma: with a
// great misfit, wide and weak, between few samples.
TEST(FastSpacetime, SettlesSlowFits) {
    for (const std::uint64_t seed : {75'920, 76'340, 79'180})
        expect_no_broken_bound(seed, seed + 10);
}

}  // namespace
}  // namespace stria::test

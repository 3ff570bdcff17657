#include "tests/host/cli/rendered_profile_trial.h"

/// Spacetime against spatial peaks on frames of the simulator.
namespace stria::test_support {
namespace {

// Curless and Levoy's card as accuracy.md A.1 reads it: pixel 0.25 mm, beam 0.45 mm, 30 degrees,
// 10:1; published: 85 % less.
TEST(RenderedProfile, TheCardOf1995) { expect_card_within_theory(10, 0.45, 0); }
TEST(RenderedProfile, CornerOf120Degrees) { expect_corner_by_the_footprint(120, true, 0.13); }
TEST(RenderedProfile, StripOfFourMillimetres) { expect_shorter_curl(0.13); }

}  // namespace
}  // namespace stria::test_support

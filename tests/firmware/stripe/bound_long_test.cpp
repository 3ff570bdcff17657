#include <gtest/gtest.h>

#include "tests/firmware/stripe/method_trials.h"
#include "tests/firmware/stripe/spatial_trials.h"
#include "tests/firmware/stripe/temporal_trials.h"

namespace stria::test {
namespace {

TEST(SpatialBound, IsReachedIn20000Trials) {
    expect_spatial_reaches_bound(20000, {10, 15, 20, 30, 50, 100, 200});
}

TEST(PeakMethods, ReachWhatIsPublishedIn20000Trials) {
    expect_methods_reach_published(20000, {10, 20, 50, 100, 200});
}

TEST(PeakMethods, SayTheirOwnSigmaIn20000Trials) { expect_honest_sigmas(20000); }

TEST(TemporalBound, IsReachedIn20000Trials) {
    expect_temporal_reaches_bound(20000, {10, 15, 20, 30, 50, 100, 200});
}

TEST(FastTemporalBound, IsReachedIn20000Trials) {
    expect_fast_reaches_bound(20000, {10, 15, 20, 30, 50, 100, 200});
}

}  // namespace
}  // namespace stria::test

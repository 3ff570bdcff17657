#include <gtest/gtest.h>

#include "tests/firmware/stripe/temporal_trials.h"

namespace stria::test {
namespace {

TEST(TemporalBound, IsReachedIn1000Trials) { expect_temporal_reaches_bound(1000, {10, 30, 200}); }

}  // namespace
}  // namespace stria::test

#include <gtest/gtest.h>

#include "tests/firmware/stripe/spatial_trials.h"

namespace stria::test {
namespace {

TEST(SpatialBound, IsReachedIn1000Trials) { expect_spatial_reaches_bound(1000, {10, 30, 200}); }

}  // namespace
}  // namespace stria::test

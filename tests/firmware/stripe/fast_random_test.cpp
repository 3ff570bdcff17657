#include <gtest/gtest.h>

#include "tests/firmware/stripe/fast_random_trials.h"

namespace stria::test {
namespace {

TEST(FastSpacetime, BreaksNoBoundInRandomSweeps) { expect_no_broken_bound(0, 300); }

}  // namespace
}  // namespace stria::test

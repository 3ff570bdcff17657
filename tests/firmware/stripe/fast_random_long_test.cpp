#include <gtest/gtest.h>

#include "tests/firmware/stripe/fast_random_trials.h"

namespace stria::test {
namespace {

TEST(FastSpacetime, BreaksNoBoundIn100000RandomSweeps) { expect_no_broken_bound(0, 100'000); }

}  // namespace
}  // namespace stria::test

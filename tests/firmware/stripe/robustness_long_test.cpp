#include <gtest/gtest.h>

#include "tests/firmware/stripe/robustness_trials.h"

namespace stria::test {
namespace {

TEST(Robustness, DropsJitterAndAmbientLightKeepToTheBoundIn20000Trials) { expect_robust(20000); }

}  // namespace
}  // namespace stria::test

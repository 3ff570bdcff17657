#include "firmware/core/median.h"

#include <gtest/gtest.h>

namespace stria {
namespace {

TEST(Median, IsTheMiddleOneOrTheUpperOfTwo) {
    EXPECT_EQ(median(std::vector<int>{5, 1, 9}), 5);
    EXPECT_EQ(median(std::vector<double>{4, 1, 3, 2}), 3);
    EXPECT_EQ(median(std::vector<float>{7}), 7);
}

TEST(Median, OfNothingIsWhatTheCallerSays) {
    EXPECT_EQ(median(std::vector<double>{}), 0);
    EXPECT_EQ(median(std::vector<double>{}, -1.0), -1);
}

}  // namespace
}  // namespace stria

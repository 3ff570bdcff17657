#include "firmware/core/result.h"

#include <gtest/gtest.h>

#include <memory>

namespace stria {
namespace {

Result<int> half(int value) {
    if (value % 2 != 0) return Failure{"expected an even number", 7};
    return value / 2;
}

TEST(Result, HoldsAValueOrAFailure) {
    const Result<int> good = half(8);
    ASSERT_TRUE(good.ok());
    EXPECT_TRUE(static_cast<bool>(good));
    EXPECT_EQ(*good, 4);
    const Result<int> bad = half(3);
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.failure().message, "expected an even number");
    EXPECT_EQ(bad.failure().byte_offset, 7U);
}

TEST(Result, GivesItsValueAway) {
    Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
    const std::unique_ptr<int> taken = std::move(result).value();
    EXPECT_EQ(*taken, 5);
}

TEST(Result, LetsItsValueBeChanged) {
    Result<std::string> text(std::string("a"));
    *text += "b";
    EXPECT_EQ(text->size(), 2U);
}

TEST(Status, IsDoneUnlessItFailed) {
    EXPECT_TRUE(Status().ok());
    const Status failed = Failure{"no answer"};
    EXPECT_FALSE(failed.ok());
    EXPECT_EQ(failed.failure().message, "no answer");
}

}  // namespace
}  // namespace stria

#include "firmware/stripe/large_pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace stria {
namespace {

TEST(LargePages, LeaveContentsAlone) {
    std::vector<std::uint8_t> bytes(std::size_t{5} << 20);
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i % 251);
    const std::vector<std::uint8_t> before = bytes;
    ask_for_large_pages(bytes.data(), bytes.size());
    EXPECT_TRUE(bytes == before);
    std::fill(bytes.begin(), bytes.end(), std::uint8_t{1});
    EXPECT_EQ(std::count(bytes.begin(), bytes.end(), 1), static_cast<long>(bytes.size()));
}

TEST(LargePages, TakeAnyRange) {
    std::vector<std::uint8_t> bytes(100);
    ask_for_large_pages(bytes.data(), bytes.size());
    ask_for_large_pages(bytes.data() + 1, 0);
    ask_for_large_pages(nullptr, 0);
}

}  // namespace
}  // namespace stria

#include "firmware/core/axis_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace stria {
namespace {

const AxisLog kLog = {.samples = {{1000, 1.0}, {3000, 2.0}, {4000, -1.0}}, .sigma_s = 0.01};

TEST(AxisLog, IsLinearBetweenSamples) {
    const auto state = position_at(kLog, 1500);
    ASSERT_TRUE(state);
    EXPECT_NEAR(state->s, 1.25, 1e-12);          // rounding
    EXPECT_NEAR(state->ds_dt, 500'000.0, 1e-6);  // 1 per 2000 ns
    EXPECT_EQ(state->sigma_s, 0.01);
    EXPECT_NEAR(position_at(kLog, 3250)->s, 1.25, 1e-12);
    EXPECT_NEAR(position_at(kLog, 3250)->ds_dt, -3e6, 1e-6);
}

TEST(AxisLog, GivesSamplesThemselves) {
    for (const AxisSample& sample : kLog.samples)
        EXPECT_NEAR(position_at(kLog, sample.t_ns)->s, sample.s, 1e-12);
}

TEST(AxisLog, IsEmptyOutsideItsSpanAndWithFewSamples) {
    EXPECT_FALSE(position_at(kLog, 999));
    EXPECT_FALSE(position_at(kLog, 4001));
    EXPECT_FALSE(position_at({}, 0));
    EXPECT_FALSE(position_at({.samples = {{5, 1.0}}}, 5));
}

TEST(AxisLog, KeepsNanosecondsAtLargeTimes) {
    const TimeNs start = TimeNs{1} << 60;  // where a double no longer holds single nanoseconds
    const AxisLog log = {.samples = {{start, 0.0}, {start + 1000, 1000.0}}};
    for (TimeNs t = 0; t <= 1000; t += 7)
        EXPECT_NEAR(position_at(log, start + t)->s, static_cast<double>(t), 1e-9);
}

TEST(AxisLog, IsInvalidWhereTimesDoNotAscendOrNumbersAreNotFinite) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(is_valid(kLog));
    EXPECT_TRUE(is_valid(AxisLog{}));
    EXPECT_FALSE(is_valid({.samples = {{2, 0.0}, {2, 1.0}}}));
    EXPECT_FALSE(is_valid({.samples = {{2, 0.0}, {1, 1.0}}}));
    EXPECT_FALSE(is_valid({.samples = {{2, nan}}}));
    EXPECT_FALSE(is_valid({.samples = {}, .sigma_s = -1}));
    EXPECT_FALSE(is_valid({.samples = {}, .sigma_s = nan}));
}

}  // namespace
}  // namespace stria

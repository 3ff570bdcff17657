#include "firmware/core/pulse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "firmware/core/frame.h"

namespace stria {
namespace {

Pulse pulse_at(TimeNs t_ns) {
    Pulse pulse;
    pulse.t_ns = t_ns;
    pulse.amplitude = static_cast<float>(t_ns);
    return pulse;
}

/// 2 x 2 cells of 1, 0, 2 and 1 pulses.
PulseMap sample_map() {
    PulseMap map;
    map.width = map.height = 2;
    map.cell_begin = {0, 1, 1, 3, 4};
    map.pulses = {pulse_at(10), pulse_at(20), pulse_at(900), pulse_at(30)};
    return map;
}

TEST(PulseMap, GivesTheCellsPulses) {
    const PulseMap map = sample_map();
    EXPECT_TRUE(is_valid(map));
    EXPECT_EQ(map.cell(0, 0).size(), 1U);
    EXPECT_TRUE(map.cell(1, 0).empty());
    ASSERT_EQ(map.cell(0, 1).size(), 2U);
    EXPECT_EQ(map.cell(0, 1)[1].t_ns, 900);
    EXPECT_EQ(map.cell(1, 1)[0].t_ns, 30);
}

TEST(PulseMap, IsInvalidWhereItsOffsetsOrNumbersAre) {
    const auto valid = [](auto change) {
        PulseMap map = sample_map();
        change(map);
        return is_valid(map);
    };
    EXPECT_FALSE(valid([](PulseMap& m) { m.cell_begin[1] = 2; }));  // then 1: descends
    EXPECT_FALSE(valid([](PulseMap& m) { m.cell_begin[0] = 1; }));
    EXPECT_FALSE(valid([](PulseMap& m) { m.cell_begin.back() = 5; }));
    EXPECT_FALSE(valid([](PulseMap& m) { m.cell_begin.pop_back(); }));
    EXPECT_FALSE(valid([](PulseMap& m) { m.width = -2; }));
    EXPECT_FALSE(valid([](PulseMap& m) { m.height = kMaxFrameSide + 1; }));
    EXPECT_FALSE(valid([](PulseMap& m) { m.pulses[2].s = std::nan(""); }));
    EXPECT_FALSE(
        valid([](PulseMap& m) { m.pulses[0].sigma = std::numeric_limits<float>::infinity(); }));
    PulseMap crowded;
    crowded.width = crowded.height = 1;
    crowded.cell_begin = {0, kMaxPulsesPerCell + 1};
    crowded.pulses.resize(kMaxPulsesPerCell + 1);
    EXPECT_FALSE(is_valid(crowded));
    crowded.cell_begin = {0, kMaxPulsesPerCell};
    crowded.pulses.resize(kMaxPulsesPerCell);
    EXPECT_TRUE(is_valid(crowded));
}

TEST(PulseMap, TakesPositionsFromTheLogAndRemovesWhatItDoesNotCover) {
    PulseMap map = sample_map();
    const AxisLog log = {.samples = {{0, 0.0}, {100, 1.0}}};
    EXPECT_EQ(assign_axis_positions(map, log), 1U);  // t = 900
    EXPECT_TRUE(is_valid(map));
    EXPECT_EQ(map.cell_begin, (std::vector<std::uint32_t>{0, 1, 1, 2, 3}));
    EXPECT_NEAR(map.cell(0, 0)[0].s, 0.1, 1e-12);
    EXPECT_NEAR(map.cell(0, 1)[0].s, 0.2, 1e-12);
    EXPECT_NEAR(map.cell(1, 1)[0].s, 0.3, 1e-12);
    EXPECT_NEAR(map.cell(1, 1)[0].ds_dt, 1e7, 1e-3);  // 1 per 100 ns
    EXPECT_EQ(map.cell(1, 1)[0].amplitude, 30.0F);
}

TEST(PulseMap, AddsTheDelayToTheTime) {
    PulseMap map = sample_map();
    const AxisLog log = {.samples = {{0, 0.0}, {1000, 1.0}}};
    EXPECT_EQ(assign_axis_positions(map, log, -15.2), 1U);  // t = 10 lies before the log then
    EXPECT_NEAR(map.cell(0, 1)[0].s, 0.005, 1e-12);         // 20 - 15 ns
}

TEST(PulseMap, SpeedIsThatOverThePulseNotOfOneSegment) {
    // 1 per s, but for one position that is 0.05 too far.
    AxisLog log;
    for (int k = 0; k <= 20; ++k) log.samples.push_back({k * kNsPerSecond, double(k)});
    log.samples[10].s += 0.05;
    PulseMap map;
    map.width = map.height = 1;
    map.cell_begin = {0, 1};
    map.pulses.resize(1);
    map.pulses[0].t_ns = 21 * kNsPerSecond / 2;
    map.pulses[0].width = 3e9f;
    assign_axis_positions(map, log);
    EXPECT_NEAR(map.pulses[0].ds_dt, 1.0, 1e-9);
    EXPECT_NEAR(map.pulses[0].s, 10.525, 1e-9);
    // Spatial peaks have a width in px, and too near the log's end there is no other side.
    map.mode = StripeMode::spatial;
    assign_axis_positions(map, log);
    EXPECT_NEAR(map.pulses[0].ds_dt, 0.95, 1e-9);
    map.mode = StripeMode::spacetime;
    map.pulses[0].t_ns = 20 * kNsPerSecond;
    assign_axis_positions(map, log);
    EXPECT_NEAR(map.pulses[0].ds_dt, 1.0, 1e-9);
}

TEST(PulseMap, TakesAnEmptyMap) {
    PulseMap map;
    map.cell_begin = {0};
    EXPECT_TRUE(is_valid(map));
    EXPECT_EQ(assign_axis_positions(map, {}), 0U);
}

}  // namespace
}  // namespace stria

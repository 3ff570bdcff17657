#include "firmware/acquire/acquire.h"

#include <gtest/gtest.h>

#include <vector>

#include "firmware/acquire/safe_state.h"
#include "tests/firmware/acquire/fake_machine.h"

namespace stria {
namespace {

struct KeepingSink : AcquireSink {
    Status take_frame(const Frame& frame) override {
        if (++calls == fail_at) return Failure{"the sink is full"};
        (frame.laser_power == 0 ? off_frames : frames).push_back(frame);
        return {};
    }
    Status take_axis_log(const AxisLog& log) override {
        if (++calls == fail_at) return Failure{"the sink is full"};
        logs.push_back(log);
        return {};
    }
    Status take_pulse_map(const PulseMap& map) override {
        if (++calls == fail_at) return Failure{"the sink is full"};
        maps.push_back(map);
        return {};
    }
    void take_status(const AcquireStatus& now) override { status = now; }

    int calls = 0, fail_at = 0;
    std::vector<Frame> off_frames, frames;
    std::vector<AxisLog> logs;
    std::vector<PulseMap> maps;
    AcquireStatus status;
};

ScanPlan small_plan() {
    ScanPlan plan;
    plan.mode = StripeMode::spatial;
    plan.from = 0.5;
    plan.to = 3.0;
    plan.step = 0.1;
    plan.off_frames = 2;
    plan.record = RecordWhat::both;
    return plan;
}

class Acquire : public testing::Test {
  protected:
    AcquireReport run(const ScanPlan& plan) {
        return run_plan(plan, machine.devices(), options, sink, stop);
    }
    static void expect_safe(const FakeMachine& m) {
        EXPECT_FALSE(m.laser_on);
        EXPECT_FALSE(m.drive_on);
        EXPECT_FALSE(m.streaming);
    }
    void expect_safe() const { expect_safe(machine); }

    FakeMachine machine;
    AcquireOptions options;
    KeepingSink sink;
    std::atomic<bool> stop = false;
};

TEST_F(Acquire, TakesOffFramesThenTheSweep) {
    const AcquireReport report = run(small_plan());
    EXPECT_TRUE(report.complete) << report.reason;
    expect_safe();
    ASSERT_EQ(sink.off_frames.size(), 2U);
    EXPECT_NEAR(static_cast<double>(sink.frames.size()), 26.0,
                1.0);  // 0.5 to 3 in steps of 0.1, the phase is free
    EXPECT_EQ(report.status.frames, sink.frames.size());
    EXPECT_EQ(report.status.frames_expected, 26U);
    EXPECT_EQ(report.status.frames_dropped, 0U);
    for (const Frame& frame : sink.frames) EXPECT_EQ(frame.laser_power, 1.0F);
    for (const Frame& frame : sink.off_frames)
        EXPECT_LE(*std::max_element(frame.bytes.begin(), frame.bytes.end()), 10);
    ASSERT_EQ(sink.maps.size(), 1U);
    EXPECT_TRUE(is_valid(sink.maps[0]));
    ASSERT_EQ(sink.logs.size(), 2U);
}

TEST_F(Acquire, OffFramesStandAtTheirPositions) {
    ScanPlan plan = small_plan();
    plan.off_frames = 3;
    ASSERT_TRUE(run(plan).complete);
    const double expected[] = {0.5, 1.75, 3.0};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto state = position_at(sink.logs[0], sink.off_frames[i].row_time(0));
        ASSERT_TRUE(state);
        EXPECT_NEAR(state->s, expected[i], 1e-9);
    }
}

TEST_F(Acquire, FramesLieWithinTheSweepAStepApart) {
    ASSERT_TRUE(run(small_plan()).complete);
    double last = -1;
    for (const Frame& frame : sink.frames) {
        const auto state = position_at(sink.logs[1], frame.row_time(FakeMachine::kHeight / 2));
        ASSERT_TRUE(state);
        EXPECT_GE(state->s, 0.5 - 1e-6);
        EXPECT_LE(state->s, 3.0 + 1e-6);
        if (last >= 0) {
            EXPECT_NEAR(state->s - last, 0.1, 1e-6);
        }
        last = state->s;
    }
}

TEST_F(Acquire, FindsTheStripeWhereItStands) {
    ASSERT_TRUE(run(small_plan()).complete);
    const PulseMap& map = sink.maps[0];
    EXPECT_EQ(map.pulses.size(), static_cast<std::size_t>(map.width * map.height));
    for (const Pulse& pulse : map.pulses) {
        EXPECT_NEAR(pulse.u, 20 + 8 * std::sin(pulse.v / 5.0F), 0.02);  // px, 8-bit quantisation
        EXPECT_GE(pulse.s, 0.5 - 1e-6);
        EXPECT_NEAR(pulse.ds_dt, 0.1 / 2e-3, 1e-3);
    }
}

TEST_F(Acquire, SpacetimeTimesThePassingStripe) {
    machine.swept = true;
    ScanPlan plan = small_plan();
    plan.mode = StripeMode::spacetime;
    plan.step = 0.05;
    plan.record = RecordWhat::pulses;
    ASSERT_TRUE(run(plan).complete);
    EXPECT_TRUE(sink.frames.empty());
    ASSERT_EQ(sink.maps.size(), 1U);
    const PulseMap& map = sink.maps[0];
    ASSERT_EQ(map.width, FakeMachine::kWidth);
    std::size_t seen = 0;
    for (const Pulse& pulse : map.pulses) {
        if ((pulse.flags & kPulseTouchesSequenceEnd) != 0) continue;
        EXPECT_NEAR(pulse.s, pulse.u / 10, 0.003);  // 0.03 px of 1.2
        ++seen;
    }
    EXPECT_GT(seen, 15U * FakeMachine::kHeight);
}

TEST_F(Acquire, EveryExposureAndDirectionIsAPass) {
    ScanPlan plan = small_plan();
    plan.both_directions = true;
    plan.exposures_us = {500, 1000};
    const AcquireReport report = run(plan);
    ASSERT_TRUE(report.complete) << report.reason;
    ASSERT_EQ(sink.maps.size(), 4U);
    EXPECT_EQ(report.status.frames_expected, 4 * 26U);
    EXPECT_GT(sink.maps[0].pulses[0].ds_dt, 0);
    EXPECT_LT(sink.maps[1].pulses[0].ds_dt, 0);
    EXPECT_EQ(sink.maps[1].pulses[0].exposure_index, 0);
    EXPECT_EQ(sink.maps[2].pulses[0].exposure_index, 1);
    EXPECT_EQ(sink.frames.front().exposure_ns, 500 * kNsPerUs);
    EXPECT_EQ(sink.frames.back().exposure_ns, 1000 * kNsPerUs);
}

TEST_F(Acquire, CountsLostFrames) {
    machine.drop_frame = 15;  // within the sweep: the first 10 are the run-up
    const AcquireReport report = run(small_plan());
    EXPECT_TRUE(report.complete);
    EXPECT_EQ(report.status.frames_dropped, 1U);
    EXPECT_EQ(sink.maps[0].frames_dropped, 1U);
}

TEST_F(Acquire, TakesAFrameOnceThatComesTwice) {
    machine.repeat_frame = 15;
    const AcquireReport report = run(small_plan());
    EXPECT_TRUE(report.complete);
    EXPECT_EQ(report.status.frames_dropped, 0U);
    EXPECT_EQ(sink.maps[0].frames_dropped, 0U);
    for (std::size_t i = 1; i < sink.frames.size(); ++i)
        EXPECT_EQ(sink.frames[i].sequence, sink.frames[i - 1].sequence + 1);
}

// The safe state from every step: whichever device call fails, the laser ends off.
TEST_F(Acquire, EveryFailingCallEndsInTheSafeState) {
    ScanPlan plan = small_plan();
    plan.to = 1.0;
    plan.both_directions = true;
    ASSERT_TRUE(run(plan).complete);
    const int count = machine.calls;
    ASSERT_GT(count, 30);
    for (int n = 1; n <= count; ++n) {
        FakeMachine failing;
        failing.fail_at = n;
        KeepingSink kept;
        const AcquireReport report = run_plan(plan, failing.devices(), options, kept, stop);
        expect_safe(failing);
        if (n > count - 3) continue;  // the last three are make_safe's own, which insists
        EXPECT_FALSE(report.complete) << n;
        EXPECT_NE(report.reason.find("failed"), std::string::npos) << n;
    }
}

TEST_F(Acquire, EveryFailingSinkEndsInTheSafeState) {
    for (int n = 1; n <= 20; ++n) {
        FakeMachine fresh;
        KeepingSink failing;
        failing.fail_at = n;
        const auto report = run_plan(small_plan(), fresh.devices(), options, failing, stop);
        expect_safe(fresh);
        EXPECT_EQ(report.reason, "the sink is full") << n;
    }
}

TEST_F(Acquire, AnOpenInterlockEndsItAndKeepsWhatCame) {
    machine.interlock_opens_at = machine.now + 100 * kNsPerMs;
    const AcquireReport report = run(small_plan());
    EXPECT_FALSE(report.complete);
    EXPECT_EQ(report.reason, "the interlock is open");
    EXPECT_FALSE(machine.lit_with_open_interlock);
    expect_safe();
    EXPECT_GT(sink.frames.size(), 2U);
    ASSERT_EQ(sink.maps.size(), 1U);
    EXPECT_EQ(sink.maps[0].frames, sink.frames.size());
}

TEST_F(Acquire, AnInterlockThatIsOpenNeverLetsTheLaserOn) {
    machine.interlock_opens_at = 0;
    EXPECT_FALSE(run(small_plan()).complete);
    EXPECT_EQ(machine.emission_s, 0);
}

TEST_F(Acquire, StopsOnRequestWithinAFrame) {
    int given = 0;
    machine.on_frame = [&] {
        if (++given == 20) stop = true;
    };
    const AcquireReport report = run(small_plan());
    EXPECT_EQ(report.reason, "stopped on request");
    EXPECT_EQ(given, 20);
    expect_safe();
}

TEST_F(Acquire, AUsedUpEmissionBudgetEndsIt) {
    ScanPlan plan = small_plan();
    plan.max_emission_s = 0.06;  // the sweep alone takes 0.05 s, run-up and way beyond 0.04 s
    const AcquireReport report = run(plan);
    EXPECT_FALSE(report.complete);
    EXPECT_NE(report.reason.find("used up"), std::string::npos) << report.reason;
    EXPECT_LT(machine.emission_s, 0.06 + 0.004);  // two frames
    EXPECT_NEAR(report.status.emission_s, machine.emission_s, 1e-9);
    expect_safe();
}

TEST_F(Acquire, ACameraThatFallsSilentEndsIt) {
    machine.silent_from_frame = 20;
    const AcquireReport report = run(small_plan());
    EXPECT_EQ(report.reason, "the camera gave no frame in time");
    EXPECT_LT(machine.emission_s, 1.2);  // 3 periods + 1 s
    expect_safe();
    EXPECT_EQ(sink.maps.size(), 1U);
}

TEST_F(Acquire, AnAxisThatStallsEndsIt) {
    machine.axis_stalls_at = 1.5;
    const AcquireReport report = run(small_plan());
    EXPECT_NE(report.reason.find("axis stopped"), std::string::npos) << report.reason;
    expect_safe();
    EXPECT_EQ(sink.maps.size(), 1U);
}

TEST_F(Acquire, RefusesWhatTheMachineCannotDo) {
    const auto refusal = [&](auto change) {
        ScanPlan plan = small_plan();
        change(plan);
        const std::string why = validate(plan, machine.devices(), options);
        EXPECT_EQ(run(plan).reason, why);
        EXPECT_EQ(machine.emission_s, 0);
        return why;
    };
    EXPECT_NE(refusal([](ScanPlan& p) { p.from = -2; }).find("from = -2"), std::string::npos);
    EXPECT_NE(refusal([](ScanPlan& p) { p.to = 11; }).find("to = 11"), std::string::npos);
    EXPECT_NE(refusal([](ScanPlan& p) { p.lasers = {1}; }).find("no laser 1"), std::string::npos);
    EXPECT_NE(refusal([](ScanPlan& p) { p.exposures_us = {1.0}; }).find("exposures_us"),
              std::string::npos);
    EXPECT_NE(refusal([](ScanPlan& p) { p.max_emission_s = 0.01; }).find("laser time"),
              std::string::npos);
    options.spacetime_per_pixel = false;
    const std::string why = refusal([](ScanPlan& p) { p.mode = StripeMode::spacetime; });
    for (const char* word : {"image paths", "none", "record = frames", "mode = spatial"})
        EXPECT_NE(why.find(word), std::string::npos) << why;
}

TEST_F(Acquire, ASlowAxisLengthensTheFramePeriod) {
    ScanPlan plan = small_plan();
    plan.step = 1.0;  // 100 a second at most: 10 ms a frame
    EXPECT_EQ(passes_of(plan, machine.devices(), options)[0].frame_period_ns, 10 * kNsPerMs);
    plan.step = 0.1;
    EXPECT_EQ(passes_of(plan, machine.devices(), options)[0].frame_period_ns, 2 * kNsPerMs);
    options.frame_period_ns = 7 * kNsPerMs;
    EXPECT_EQ(passes_of(plan, machine.devices(), options)[0].frame_period_ns, 7 * kNsPerMs);
}

TEST_F(Acquire, MakeSafeNamesAPartThatRefusesTwice) {
    struct Stuck : Laser {
        Status off() override { return Failure{"stuck"}; }
        Status on(float) override { return {}; }
    } stuck;
    Devices devices = machine.devices();
    devices.further_lasers = {&stuck};
    machine.laser_on = machine.drive_on = true;
    const Status safe = make_safe(devices);
    ASSERT_FALSE(safe);
    EXPECT_EQ(safe.failure().message, "laser does not turn off: stuck");
    expect_safe();
}

}  // namespace
}  // namespace stria

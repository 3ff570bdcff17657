#include "firmware/acquire/path_sweep.h"

#include <gtest/gtest.h>

#include <cstring>
#include <vector>

#include "tests/firmware/acquire/fake_machine.h"

/// Pulses along image paths on the scanner, on a fake rail: against the analysis of the recorded
/// frames, and with every failure on the way.
namespace stria {
namespace {

struct PathSink : AcquireSink {
    Status take_frame(const Frame& frame) override {
        frames.push_back(frame);
        return {};
    }
    Status take_axis_log(const AxisLog& more) override {
        append(log, more);
        return {};
    }
    Status take_pulse_map(const PulseMap& map) override {
        maps.push_back(map);
        return {};
    }
    void take_status(const AcquireStatus&) override {}

    static void append(AxisLog& log, const AxisLog& more) {
        log.sigma_s = more.sigma_s;
        for (const AxisSample& sample : more.samples)
            if (log.samples.empty() || sample.t_ns > log.samples.back().t_ns)
                log.samples.push_back(sample);
    }

    std::vector<Frame> frames;
    AxisLog log;
    std::vector<PulseMap> maps;
};

class PathRun : public testing::Test {
  protected:
    PathRun() {
        options.spacetime_per_pixel = false;
        options.path_tables = {FakeMachine::paths()};
        plan.mode = StripeMode::spacetime;
        plan.from = 0.5;
        plan.to = 4.5;
        plan.step = 0.05;
        plan.record = RecordWhat::both;
    }
    AcquireReport run() { return run_plan(plan, machine.devices(), options, sink, stop); }

    FakeMachine machine;
    AcquireOptions options;
    ScanPlan plan;
    PathSink sink;
    std::atomic<bool> stop = false;
};

/// The same frames once the whole log is known.
PulseMap from_recording(const PathSink& sink, const CameraInfo& camera) {
    PathAnalyser analyser(FakeMachine::paths(), camera.bits, camera.noise);
    for (const Frame& frame : sink.frames)
        if (const auto axis = position_at(sink.log, frame.row_time(0))) analyser.add(frame, *axis);
    PulseMap map = analyser.finish();
    assign_axis_positions(map, sink.log);
    return map;
}

/// The stripe is there in every row of every frame; but the first and last frames see half a pulse,
/// and between the outermost rows light cannot be interpolated.
void expect_every_inner_row(const PulseMap& map) {
    constexpr int kHalfPulse = 9;  // 3.5 widths of 0.12 in steps of 0.05
    ASSERT_GT(map.width, 4 * kHalfPulse);
    for (int v = 1; v < map.height - 2; ++v)
        for (int k = kHalfPulse; k < map.width - kHalfPulse; ++k)
            ASSERT_EQ(map.cell(k, v).size(), 1U) << "frame " << k << ", row " << v;
}

void expect_same_bytes(const PulseMap& a, const PulseMap& b) {
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.cell_begin, b.cell_begin);
    ASSERT_EQ(a.pulses.size(), b.pulses.size());
    for (std::size_t i = 0; i < a.pulses.size(); ++i) {
        const Pulse &p = a.pulses[i], &q = b.pulses[i];
        const auto key = [](const Pulse& x) {
            return std::vector<double>{x.u,
                                       x.v,
                                       static_cast<double>(x.t_ns),
                                       x.s,
                                       x.ds_dt,
                                       x.amplitude,
                                       x.width,
                                       x.sigma,
                                       x.background,
                                       x.chi_square,
                                       static_cast<double>(x.flags)};
        };
        ASSERT_EQ(key(p), key(q)) << i;  // bit for bit: every field compares equal
    }
}

TEST_F(PathRun, MeasuresWhatTheRecordedFramesTell) {
    const AcquireReport report = run();
    ASSERT_TRUE(report.complete) << report.reason;
    ASSERT_EQ(sink.maps.size(), 1U);
    const PulseMap& map = sink.maps[0];
    EXPECT_EQ(map.mode, StripeMode::spacetime);
    EXPECT_EQ(map.width, static_cast<int>(sink.frames.size()));
    expect_every_inner_row(map);
    for (const Pulse& pulse : map.pulses) {
        if ((pulse.flags & kPulseTouchesSequenceEnd) != 0) continue;
        EXPECT_NEAR(pulse.u, 20 + 8 * std::sin(pulse.v / 5.0F), 0.05);  // px, 8 bits, interpolated
    }
    expect_same_bytes(map, from_recording(sink, machine.devices().camera.info()));
}

TEST_F(PathRun, BothDirectionsFollowTheSamePaths) {
    plan.both_directions = true;
    ASSERT_TRUE(run().complete);
    ASSERT_EQ(sink.maps.size(), 2U);
    EXPECT_LT(sink.maps[1].pulses.front().ds_dt, 0);
    expect_every_inner_row(sink.maps[1]);
}

TEST_F(PathRun, EachLaserNeedsItsPaths) {
    EXPECT_EQ(paths_followed(plan, options).size(), 1U);
    plan.lasers = {0, 1};
    EXPECT_TRUE(paths_followed(plan, options).empty());
    options.path_tables.push_back(FakeMachine::paths(1));
    const auto tables = paths_followed(plan, options);
    ASSERT_EQ(tables.size(), 2U);
    EXPECT_EQ(tables[1]->laser_id, 1);
    plan.record = RecordWhat::frames;  // the host follows
    EXPECT_TRUE(paths_followed(plan, options).empty());
}

TEST_F(PathRun, RefusesPathsThatAreNotOfThisMachine) {
    const auto why = [&](auto change) {
        PathTable table = FakeMachine::paths();
        change(table);
        return check_paths(table, machine.devices(), options);
    };
    EXPECT_EQ(why([](PathTable&) {}), "");
    EXPECT_NE(
        why([](PathTable& t) { t.image_width = 64; }).find("64 x 24: expected the camera's 40"),
        std::string::npos);
    EXPECT_NE(why([](PathTable& t) { t.laser_id = 3; }).find("laser 3"), std::string::npos);
    EXPECT_NE(why([](PathTable& t) { t.width_s[0] = 0; }).find("width_s"), std::string::npos);
    EXPECT_NE(why([](PathTable& t) { t.model_hash = "a\nb"; }).find("printable"),
              std::string::npos);
    options.spacetime_per_pixel = true;
    EXPECT_NE(why([](PathTable&) {}).find("surface points"), std::string::npos);
}

TEST_F(PathRun, ALogThatStandsStillEndsTheRunWithTheLaserOff) {
    plan.step = 0.02;
    machine.log_ends_at = machine.now + 200 * kNsPerMs;
    const AcquireReport report = run();
    EXPECT_FALSE(report.complete);
    EXPECT_NE(report.reason.find("the axis log lags behind the camera: 64 frames"),
              std::string::npos)
        << report.reason;
    EXPECT_FALSE(machine.laser_on);
    EXPECT_FALSE(machine.drive_on);
    EXPECT_EQ(sink.maps.size(), 1U);  // of the frames that the log covers
}

TEST_F(PathRun, EveryFailingCallEndsInTheSafeState) {
    plan.to = 1.0;
    ASSERT_TRUE(run().complete);
    const int count = machine.calls;
    for (int n = 1; n <= count; ++n) {
        FakeMachine failing;
        failing.fail_at = n;
        PathSink kept;
        run_plan(plan, failing.devices(), options, kept, stop);
        EXPECT_FALSE(failing.laser_on) << n;
        EXPECT_FALSE(failing.drive_on) << n;
        EXPECT_FALSE(failing.streaming) << n;
    }
}

}  // namespace
}  // namespace stria

#include <algorithm>
#include <cmath>

#include "tests/sim/devices_contract.h"
#include "tests/sim/sim_sweep.h"

/// What every machine must do, whatever it is made of; see ContractCase.
namespace stria {
namespace {

constexpr TimeNs kPatience = 10 * kNsPerSecond;

class SimulatedMachine final : public ContractMachine {
  public:
    explicit SimulatedMachine(const Scene& scene) : scanner_(scene, 1) {}
    Devices devices() override { return scanner_.devices(); }

  private:
    SimulatedScanner scanner_;
};

ContractCase simulated(const std::string& name) {
    return {name, [name] {
                Scene scene = read_scene(example_scene(name + ".toml"));
                CameraModel& camera = scene.channel.camera;  // small and quick
                camera = {.kind = LensKind::pinhole,
                          .width = 96,
                          .height = 80,
                          .fx = 140,
                          .fy = 140,
                          .cx = 47.5,
                          .cy = 39.5};
                scene.ambient_level = 0;
                scene.laser_power_mw *= 4;
                return std::make_unique<SimulatedMachine>(scene);
            }};
}

class DeviceContract : public testing::TestWithParam<ContractCase> {
  protected:
    void SetUp() override {
        machine_ = GetParam().make();
        if (!machine_) GTEST_SKIP() << "no such machine here: " << GetParam().name;
    }
    Devices devices() { return machine_->devices(); }
    TimeNs soon() { return devices().clock.now() + kPatience; }
    void configure(TimeNs exposure = kNsPerMs) {
        const CameraInfo info = devices().camera.info();
        ASSERT_TRUE(
            devices().camera.configure({exposure, std::max(exposure, info.min_frame_period_ns)}));
    }
    static double mean(const Frame& frame) {
        double sum = 0;
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x) sum += frame.sample(x, y);
        return sum / (static_cast<double>(frame.width) * frame.height);
    }
    std::unique_ptr<ContractMachine> machine_;
};

TEST_P(DeviceContract, TimeNeverRunsBackwards) {
    Clock& clock = devices().clock;
    const TimeNs before = clock.now();
    clock.sleep_until(before + 5 * kNsPerMs);
    EXPECT_GE(clock.now(), before + 5 * kNsPerMs);
    clock.sleep_until(before);  // the past is over at once
    EXPECT_GE(clock.now(), before + 5 * kNsPerMs);
}

TEST_P(DeviceContract, InfoStatesUsableLimits) {
    const CameraInfo camera = devices().camera.info();
    EXPECT_GT(camera.width, 0);
    EXPECT_GT(camera.height, 0);
    EXPECT_GE(camera.bits, 8);
    EXPECT_LE(camera.bits, 16);
    EXPECT_LT(camera.min_exposure_ns, camera.max_exposure_ns);
    EXPECT_GT(camera.noise.gain_e_per_dn, 0);
    const AxisInfo axis = devices().axis.info();
    EXPECT_LT(axis.min_s, axis.max_s);
    EXPECT_GT(axis.max_speed, 0);
}

TEST_P(DeviceContract, LaserOffMeansDark) {
    Devices d = devices();
    configure();
    ASSERT_TRUE(d.laser.off());
    ASSERT_TRUE(d.camera.start());
    Frame frame;
    ASSERT_TRUE(d.camera.next_frame(frame, soon()));
    EXPECT_EQ(frame.laser_power, 0);
    const double dark = mean(frame);
    EXPECT_NEAR(dark, d.camera.info().noise.black_dn, 1);  // DN
    ASSERT_TRUE(d.laser.on(1));
    ASSERT_TRUE(d.camera.next_frame(frame, soon()));
    ASSERT_TRUE(d.camera.next_frame(frame, soon()));
    EXPECT_EQ(frame.laser_power, 1);
    EXPECT_GT(mean(frame), dark + 0.2);
    ASSERT_TRUE(d.laser.off());
    ASSERT_TRUE(d.camera.next_frame(frame, soon()));
    ASSERT_TRUE(d.camera.next_frame(frame, soon()));
    EXPECT_NEAR(mean(frame), dark, 0.05);
    EXPECT_TRUE(d.camera.stop());
}

TEST_P(DeviceContract, FramesFollowEachOtherAtThePeriod) {
    Devices d = devices();
    const CameraInfo info = d.camera.info();
    const TimeNs period = std::max<TimeNs>(4 * kNsPerMs, info.min_frame_period_ns);
    ASSERT_TRUE(d.camera.configure({kNsPerMs, period}));
    ASSERT_TRUE(d.camera.start());
    Frame last, frame;
    ASSERT_TRUE(d.camera.next_frame(last, soon()));
    for (int i = 0; i < 10; ++i) {
        ASSERT_TRUE(d.camera.next_frame(frame, soon()));
        EXPECT_EQ(frame.sequence, last.sequence + 1);
        EXPECT_NEAR(static_cast<double>(frame.exposure_start_ns - last.exposure_start_ns),
                    static_cast<double>(period),
                    6.0 * static_cast<double>(info.timestamp_sigma_ns) + 1);
        EXPECT_EQ(frame.exposure_ns, kNsPerMs);
        EXPECT_EQ(frame.width, info.width);
        EXPECT_EQ(frame.bits, info.bits);
        EXPECT_GE(d.clock.now(), frame.exposure_start_ns);
        last = frame;
    }
    EXPECT_TRUE(d.camera.stop());
}

TEST_P(DeviceContract, CameraRefusesWhatItCannotDo) {
    Devices d = devices();
    const CameraInfo info = d.camera.info();
    Frame frame;
    EXPECT_FALSE(d.camera.next_frame(frame, soon()));  // stopped
    EXPECT_FALSE(d.camera.configure({info.max_exposure_ns + 1, info.max_exposure_ns + 1}));
    EXPECT_FALSE(d.camera.configure({0, info.min_frame_period_ns}));
    EXPECT_FALSE(d.camera.configure({kNsPerMs, kNsPerMs / 2}));
    configure();
    ASSERT_TRUE(d.camera.start());
    EXPECT_FALSE(d.camera.start());
    EXPECT_FALSE(d.camera.configure({kNsPerMs, 10 * kNsPerMs}));  // runs
    EXPECT_TRUE(d.camera.stop());
    EXPECT_TRUE(d.camera.stop());  // stopping twice is allowed
}

TEST_P(DeviceContract, AFrameThatIsNotReadyFailsAtTheDeadline) {
    Devices d = devices();
    ASSERT_TRUE(d.camera.configure({20 * kNsPerMs, 20 * kNsPerMs}));
    ASSERT_TRUE(d.camera.start());
    Frame frame;
    const TimeNs deadline = d.clock.now() + 5 * kNsPerMs;
    const Status status = d.camera.next_frame(frame, deadline);
    ASSERT_FALSE(status);
    EXPECT_FALSE(status.failure().message.empty());
    EXPECT_GE(d.clock.now(), deadline);
    EXPECT_TRUE(d.camera.next_frame(frame, soon()));  // and comes later
    EXPECT_TRUE(d.camera.stop());
}

TEST_P(DeviceContract, LaserRefusesPowersOutsideItsRange) {
    Devices d = devices();
    for (float power : {0.0F, -0.1F, 1.1F, std::nanf("")}) EXPECT_FALSE(d.laser.on(power)) << power;
    EXPECT_TRUE(d.laser.off());
    EXPECT_TRUE(d.laser.off());
}

TEST_P(DeviceContract, AxisGoesWhereItIsSentAndNotBeyond) {
    Devices d = devices();
    const AxisInfo info = d.axis.info();
    const double middle = (info.min_s + info.max_s) / 2, travel = info.max_s - info.min_s;
    ASSERT_TRUE(d.axis.home());
    for (double s : {info.min_s, middle, info.max_s}) {
        ASSERT_TRUE(d.axis.move_to(s, d.clock.now() + 60 * kNsPerSecond));
        EXPECT_FALSE(d.axis.is_moving());
        d.clock.sleep_until(d.clock.now() + kNsPerMs);
        const AxisLog log = d.axis.take_log();
        ASSERT_FALSE(log.samples.empty());
        EXPECT_TRUE(is_valid(log));
        EXPECT_NEAR(log.samples.back().s, s, 6 * info.sigma_s + 1e-9 * travel);
    }
    EXPECT_FALSE(d.axis.move_to(info.max_s + 0.1 * travel, soon()));
    EXPECT_FALSE(d.axis.start_sweep(info.min_s - travel, middle, info.max_speed));
    EXPECT_FALSE(d.axis.start_sweep(info.min_s, middle, 0));
    EXPECT_FALSE(d.axis.start_sweep(info.min_s, middle, 10 * info.max_speed));
    EXPECT_FALSE(d.axis.start_sweep(info.min_s, middle, -1));
}

TEST_P(DeviceContract, AMoveThatTakesTooLongFailsAtTheDeadlineAndStops) {
    Devices d = devices();
    const AxisInfo info = d.axis.info();
    ASSERT_TRUE(d.axis.move_to(info.min_s, d.clock.now() + 60 * kNsPerSecond));
    const TimeNs deadline = d.clock.now() + kNsPerMs;
    EXPECT_FALSE(d.axis.move_to(info.max_s, deadline));
    EXPECT_GE(d.clock.now(), deadline);
    EXPECT_FALSE(d.axis.is_moving());
}

TEST_P(DeviceContract, LogCoversTheSweepAtConstantSpeed) {
    Devices d = devices();
    const AxisInfo info = d.axis.info();
    const double travel = info.max_s - info.min_s;
    for (const bool forth : {true, false}) {
        const double from = info.min_s + (forth ? 0.3 : 0.6) * travel;
        const double to = info.min_s + (forth ? 0.6 : 0.3) * travel;
        const double speed = std::min(info.max_speed / 2, travel / 2);
        ASSERT_TRUE(d.axis.move_to(from, d.clock.now() + 60 * kNsPerSecond));
        (void)d.axis.take_log();
        ASSERT_TRUE(d.axis.start_sweep(from, to, speed));
        EXPECT_TRUE(d.axis.is_moving());
        while (d.axis.is_moving()) d.clock.sleep_until(d.clock.now() + kNsPerMs);
        const AxisLog log = d.axis.take_log();
        EXPECT_TRUE(is_valid(log));
        EXPECT_EQ(log.sigma_s, info.sigma_s);
        double low = log.samples.front().s, high = low;
        for (const AxisSample& sample : log.samples) {
            low = std::min(low, sample.s);
            high = std::max(high, sample.s);
        }
        EXPECT_LE(low, std::min(from, to));
        EXPECT_GE(high, std::max(from, to));
        // Between `from` and `to` the slope over 20 samples is the speed.
        const double way = to > from ? speed : -speed;
        for (std::size_t i = 20; i < log.samples.size(); ++i) {
            const AxisSample &a = log.samples[i - 20], &b = log.samples[i];
            if (std::min(a.s, b.s) < std::min(from, to) || std::max(a.s, b.s) > std::max(from, to))
                continue;
            const double seconds = static_cast<double>(b.t_ns - a.t_ns) * 1e-9;
            // On the way to `from` the drive may run faster; the sweep is the last piece.
            if (static_cast<double>(log.samples.back().t_ns - a.t_ns) * 1e-9 >
                std::abs(to - from) / speed)
                continue;
            EXPECT_NEAR((b.s - a.s) / seconds, way, 1e-3 * speed + 9 * info.sigma_s / seconds);
        }
    }
}

TEST_P(DeviceContract, StopEndsEverySweep) {
    Devices d = devices();
    const AxisInfo info = d.axis.info();
    ASSERT_TRUE(d.axis.start_sweep(info.min_s, info.max_s, info.max_speed / 10));
    EXPECT_TRUE(d.axis.stop());
    EXPECT_FALSE(d.axis.is_moving());
    EXPECT_TRUE(d.axis.stop());
}

TEST_P(DeviceContract, InterlockIsClosedOnAMachineAtWork) {
    EXPECT_TRUE(devices().interlock.is_closed());
}

INSTANTIATE_TEST_SUITE_P(Simulated, DeviceContract,
                         testing::Values(simulated("swept"), simulated("rail"),
                                         simulated("turntable")),
                         [](const auto& param) { return param.param.name; });

// What only the simulated machine can be told to do wrong.

Scene small_scene() {
    Scene scene = read_scene(example_scene("swept.toml"));
    scene.channel.camera = {.kind = LensKind::pinhole,
                            .width = 64,
                            .height = 48,
                            .fx = 90,
                            .fy = 90,
                            .cx = 31.5,
                            .cy = 23.5};
    return scene;
}

TEST(Faults, AnOpenInterlockTakesTheLaserAway) {
    Scene scene = small_scene();
    scene.fault.interlock_opens_at_s = 0.5;
    scene.ambient_level = 0;
    scene.laser_power_mw *= 10;
    SimulatedScanner scanner(scene, 1);
    Devices d = scanner.devices();
    ASSERT_TRUE(d.laser.on(1));
    EXPECT_TRUE(d.interlock.is_closed());
    d.clock.sleep_until(kNsPerSecond);
    EXPECT_FALSE(d.interlock.is_closed());
    EXPECT_FALSE(d.laser.on(1));
    ASSERT_TRUE(d.camera.start());
    Frame frame;
    ASSERT_TRUE(d.camera.next_frame(frame, 2 * kNsPerSecond));
    EXPECT_EQ(frame.laser_power, 0);
    const int most = *std::max_element(frame.bytes.begin(), frame.bytes.end());
    EXPECT_LE(most, static_cast<int>(scene.sensor.black_dn) + 2);
}

TEST(Faults, DroppedFramesLeaveGapsAtTheirRate) {
    Scene scene = small_scene();
    scene.fault.drop_frame_probability = 0.1;
    SimulatedScanner scanner(scene, 1);
    Devices d = scanner.devices();
    ASSERT_TRUE(d.camera.start());
    Frame frame;
    for (int i = 0; i < 900; ++i)
        ASSERT_TRUE(d.camera.next_frame(frame, d.clock.now() + kNsPerSecond));
    // 900 of about 1000: four standard deviations of sqrt(1000 x 0.09) are 38.
    EXPECT_NEAR(frame.sequence + 1.0, 1000, 43);
}

TEST(Faults, ACameraThatStopsSendsNothingMore) {
    Scene scene = small_scene();
    scene.fault.camera_stops_at_frame = 5;
    SimulatedScanner scanner(scene, 1);
    Devices d = scanner.devices();
    ASSERT_TRUE(d.camera.start());
    Frame frame;
    for (int i = 0; i < 5; ++i)
        ASSERT_TRUE(d.camera.next_frame(frame, d.clock.now() + kNsPerSecond));
    const TimeNs deadline = d.clock.now() + kNsPerSecond;
    EXPECT_FALSE(d.camera.next_frame(frame, deadline));
    EXPECT_EQ(d.clock.now(), deadline);
}

TEST(Faults, FramesNotFetchedAreLost) {
    SimulatedScanner scanner(small_scene(), 1);
    Devices d = scanner.devices();
    ASSERT_TRUE(d.camera.configure({kNsPerMs, 2 * kNsPerMs}));
    ASSERT_TRUE(d.camera.start());
    Frame frame;
    ASSERT_TRUE(d.camera.next_frame(frame, kNsPerSecond));
    EXPECT_EQ(frame.sequence, 0u);
    d.clock.sleep_until(d.clock.now() + 200 * kNsPerMs);
    ASSERT_TRUE(d.camera.next_frame(frame, kNsPerSecond));
    EXPECT_EQ(frame.sequence, 101u - 16u);
}

}  // namespace
}  // namespace stria

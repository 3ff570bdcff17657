#include "tests/sim/sim_sweep.h"

#include <gtest/gtest.h>

#include <cmath>

namespace stria {
namespace {

constexpr TimeNs kLong = 1000 * kNsPerSecond;

TimeNs exposure_of(const SimulatedScanner& scanner) {
    return static_cast<TimeNs>(scanner.scene().sensor.exposure_us * 1000);
}

}  // namespace

SimSweep record_sweep(SimulatedScanner& scanner, double from, double to, double step, float power) {
    Devices devices = scanner.devices();
    const TimeNs exposure = exposure_of(scanner);
    const double most = devices.axis.info().max_speed;
    TimeNs period = std::max(exposure, devices.camera.info().min_frame_period_ns);
    period = std::max(period, static_cast<TimeNs>(std::ceil(step / most * 1e9)));
    const double speed = step / (static_cast<double>(period) * 1e-9);

    EXPECT_TRUE(devices.camera.configure({exposure, period}));
    EXPECT_TRUE(devices.axis.move_to(from, kLong));
    EXPECT_TRUE(power > 0 ? devices.laser.on(power) : devices.laser.off());
    (void)devices.axis.take_log();
    EXPECT_TRUE(devices.axis.start_sweep(from, to, speed));
    EXPECT_TRUE(devices.camera.start());
    SimSweep sweep;
    const double delay = scanner.scene().channel.axis.delay_ns;
    std::vector<TimeNs> times;
    while (devices.axis.is_moving()) {
        Frame frame;
        const Status got = devices.camera.next_frame(frame, devices.clock.now() + kLong);
        EXPECT_TRUE(got);
        if (!got) break;
        times.push_back(frame.row_time(0) + static_cast<TimeNs>(std::llround(delay)));
        sweep.frames.push_back(std::move(frame));
    }
    EXPECT_TRUE(devices.camera.stop());
    EXPECT_TRUE(devices.laser.off());
    // The truth behind the log: constant speed through `from`; the log's noise averages out.
    const AxisLog log = devices.axis.take_log();
    double sum = 0;
    int count = 0;
    const double way = to > from ? speed : -speed;
    for (const AxisSample& sample : log.samples) {
        if (sample.s < std::min(from, to) || sample.s > std::max(from, to)) continue;
        sum += static_cast<double>(sample.t_ns) * 1e-9 - (sample.s - from) / way;
        ++count;
    }
    const double at_from = sum / std::max(1, count);  // seconds
    std::vector<Frame> kept;
    for (std::size_t k = 0; k < times.size(); ++k) {
        const double s = from + way * (static_cast<double>(times[k]) * 1e-9 - at_from);
        if (s < std::min(from, to) || s > std::max(from, to)) continue;
        sweep.s.push_back(s);
        kept.push_back(std::move(sweep.frames[k]));
    }
    sweep.frames = std::move(kept);
    return sweep;
}

Frame record_still(SimulatedScanner& scanner, double s, float power, double exposure_us) {
    Devices devices = scanner.devices();
    TimeNs exposure = exposure_of(scanner);
    if (exposure_us > 0) exposure = static_cast<TimeNs>(exposure_us * 1000);
    const TimeNs period = std::max(exposure, devices.camera.info().min_frame_period_ns);
    EXPECT_TRUE(devices.camera.configure({exposure, period}));
    EXPECT_TRUE(devices.axis.move_to(s, devices.clock.now() + kLong));
    EXPECT_TRUE(power > 0 ? devices.laser.on(power) : devices.laser.off());
    EXPECT_TRUE(devices.camera.start());
    Frame frame;
    EXPECT_TRUE(devices.camera.next_frame(frame, devices.clock.now() + kLong));
    EXPECT_TRUE(devices.camera.stop());
    EXPECT_TRUE(devices.laser.off());
    return frame;
}

std::string example_scene(const std::string& name) {
    return std::string(STRIA_EXAMPLE_SCENES) + "/" + name;
}

}  // namespace stria

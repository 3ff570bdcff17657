#pragma once
#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>

#include "firmware/core/image_paths.h"
#include "firmware/devices/devices.h"

namespace stria {

/// A machine of 40 x 24 pixels on a clock that only waiting moves. Its stripe stands at column
/// 20 + 8 sin(row / 5); with `swept` it moves, at column 10 s in every row. Every device call is
/// counted, and the one numbered `fail_at` (from 1) fails.
class FakeMachine {
  public:
    static constexpr int kWidth = 40, kHeight = 24;

    int fail_at = 0;
    bool swept = false;
    TimeNs interlock_opens_at = -1;       ///< never
    int drop_frame = -1;                  ///< sequence that the camera skips, in every stream
    int repeat_frame = -1;                ///< sequence that it gives twice, in every stream
    std::int64_t silent_from_frame = -1;  ///< frame, counted over all streams
    double axis_stalls_at = 1e300;        ///< s
    TimeNs log_ends_at = std::numeric_limits<TimeNs>::max();  ///< no position is logged after it
    std::function<void()> on_frame = [] {};

    int calls = 0;
    std::atomic<bool> laser_on = false, drive_on = false;  // sessions are watched while they run
    bool streaming = false;
    bool lit_with_open_interlock = false;  ///< for longer than a frame takes
    double emission_s = 0;
    std::atomic<TimeNs> now = kNsPerSecond;

    /// Paths that move ten columns a unit of s, as if the stripe's light lay on a flat part.
    static PathTable paths(std::uint8_t laser_id = 0) {
        PathTable table;
        table.laser_id = laser_id;
        table.image_width = kWidth;
        table.image_height = kHeight;
        table.nodes_x = table.nodes_y = 2;
        table.model_hash = "0123456789abcdef";
        table.du_ds.assign(4, 10.0F);
        for (auto* column : {&table.dv_ds, &table.d2u_ds2, &table.d2v_ds2}) column->assign(4, 0.0F);
        table.width_s.assign(4, 0.12F);  // the stripe is 1.2 columns wide
        table.valid.assign(4, 1);
        return table;
    }

    Devices devices() { return {clock_, camera_, laser_, axis_, interlock_}; }

    double s_at(TimeNs time_ns) const {
        if (!moving_) return rest_s_;
        const double seconds = static_cast<double>(time_ns - sweep_begin_) * 1e-9;
        const double end = std::min(sweep_to_, axis_stalls_at);
        const double s = sweep_from_ + speed_ * std::max(0.0, seconds);
        return speed_ > 0 ? std::min(s, end) : std::max(s, sweep_to_);
    }

  private:
    Status call(const char* what) {
        if (++calls != fail_at) return {};
        return Failure{std::string(what) + " failed"};
    }
    void advance(TimeNs time_ns) {
        if (time_ns <= now) return;
        if (laser_on) emission_s += static_cast<double>(time_ns - now) * 1e-9;
        const TimeNs open_ns = interlock_opens_at < 0 ? 0 : time_ns - interlock_opens_at;
        if (laser_on && open_ns > 2 * settings_.frame_period_ns) lit_with_open_interlock = true;
        now = time_ns;
    }
    void rest_at(double s) {
        moving_ = false;
        rest_s_ = s;
    }

    void expose(Frame& frame, TimeNs start) const {
        resize(frame, kWidth, kHeight, 8);
        frame.exposure_start_ns = start;
        frame.exposure_ns = settings_.exposure_ns;
        const double s = s_at(start + settings_.exposure_ns / 2);
        for (int y = 0; y < kHeight; ++y) {
            const double u = swept ? 10 * s : 20 + 8 * std::sin(y / 5.0);
            for (int x = 0; x < kWidth; ++x) {
                const double d = (x - u) / 1.2;
                const double light = laser_on ? 180.0 * power_ * std::exp(-0.5 * d * d) : 0.0;
                frame.bytes[static_cast<std::size_t>(y * kWidth + x)] =
                    static_cast<std::uint8_t>(std::lround(10.0 + light));
            }
        }
    }

    struct FakeClock : Clock {
        explicit FakeClock(FakeMachine& machine) : m(machine) {}
        TimeNs now() override { return m.now; }
        void sleep_until(TimeNs time_ns) override { m.advance(time_ns); }
        FakeMachine& m;
    };

    struct FakeCamera : Camera {
        explicit FakeCamera(FakeMachine& machine) : m(machine) {}
        CameraInfo info() const override {
            CameraInfo info;
            info.name = "fake camera";
            info.width = kWidth;
            info.height = kHeight;
            info.min_frame_period_ns = 2 * kNsPerMs;
            info.min_exposure_ns = 10 * kNsPerUs;
            info.max_exposure_ns = 100 * kNsPerMs;
            return info;
        }
        Status configure(const CameraSettings& settings) override {
            if (m.streaming) return Failure{"the camera runs"};
            m.settings_ = settings;
            return m.call("camera configure");
        }
        Status start() override {
            if (Status done = m.call("camera start"); !done) return done;
            m.streaming = true;
            m.stream_begin_ = m.now;
            m.next_in_stream_ = 0;
            return {};
        }
        Status next_frame(Frame& frame, TimeNs deadline_ns) override {
            if (Status done = m.call("camera next_frame"); !done) return done;
            if (!m.streaming) return Failure{"the camera is stopped"};
            m.on_frame();
            if (m.silent_from_frame >= 0 && m.frames_given_ >= m.silent_from_frame) {
                m.advance(deadline_ns);
                return Failure{"the camera gave no frame in time"};
            }
            if (m.next_in_stream_ == m.drop_frame) ++m.next_in_stream_;
            const TimeNs begin = m.stream_begin_ + m.next_in_stream_ * m.settings_.frame_period_ns;
            m.advance(begin + m.settings_.exposure_ns);
            m.expose(frame, begin);
            frame.sequence = static_cast<std::uint32_t>(m.next_in_stream_);
            if (m.next_in_stream_ != m.repeat_frame || m.repeated_) ++m.next_in_stream_;
            m.repeated_ =
                m.next_in_stream_ == m.repeat_frame && frame.sequence == m.next_in_stream_;
            ++m.frames_given_;
            return {};
        }
        Status stop() override {
            if (Status done = m.call("camera stop"); !done) return done;
            m.streaming = false;
            return {};
        }
        FakeMachine& m;
    };

    struct FakeLaser : Laser {
        explicit FakeLaser(FakeMachine& machine) : m(machine) {}
        Status off() override {
            if (Status done = m.call("laser off"); !done) return done;
            m.laser_on = false;
            return {};
        }
        Status on(float power) override {
            m.laser_on = true;  // also where it then says that it failed: the worst case
            m.power_ = static_cast<double>(power);
            return m.call("laser on");
        }
        FakeMachine& m;
    };

    struct FakeAxis : Axis {
        explicit FakeAxis(FakeMachine& machine) : m(machine) {}
        AxisInfo info() const override { return {"fake axis", -1.0, 10.0, 100.0, 1e-6}; }
        Status home() override {
            m.drive_on = true;
            m.rest_at(0);
            return m.call("axis home");
        }
        Status move_to(double s, TimeNs) override {
            m.drive_on = true;
            m.advance(m.now + 10 * kNsPerMs);
            m.rest_at(s);
            m.advance(m.now + 10 * kNsPerMs);
            return m.call("axis move_to");
        }
        Status start_sweep(double from, double to, double speed) override {
            m.drive_on = true;
            m.speed_ = to > from ? speed : -speed;
            m.sweep_begin_ = m.now;
            m.sweep_from_ = from - m.speed_ * 0.02;
            m.sweep_to_ = to + m.speed_ * 0.02;
            m.moving_ = true;
            return m.call("axis start_sweep");
        }
        bool is_moving() override { return m.s_at(m.now) != m.s_at(m.now - 1); }
        AxisLog take_log() override {
            AxisLog log;
            log.sigma_s = 1e-6;
            for (; m.next_log_ <= m.now; m.next_log_ += kNsPerMs)
                if (m.next_log_ < m.log_ends_at)
                    log.samples.push_back({m.next_log_, m.s_at(m.next_log_)});
            return log;
        }
        Status stop() override {
            if (Status done = m.call("axis stop"); !done) return done;
            m.rest_at(m.s_at(m.now));
            m.drive_on = false;
            return {};
        }
        FakeMachine& m;
    };

    struct FakeInterlock : Interlock {
        explicit FakeInterlock(FakeMachine& machine) : m(machine) {}
        bool is_closed() override {
            return m.interlock_opens_at < 0 || m.now < m.interlock_opens_at;
        }
        FakeMachine& m;
    };

    FakeClock clock_{*this};
    FakeCamera camera_{*this};
    FakeLaser laser_{*this};
    FakeAxis axis_{*this};
    FakeInterlock interlock_{*this};

    CameraSettings settings_{kNsPerMs, 2 * kNsPerMs};
    TimeNs next_log_ = kNsPerSecond, stream_begin_ = 0, sweep_begin_ = 0;
    bool repeated_ = false;
    std::int64_t next_in_stream_ = 0, frames_given_ = 0;
    double power_ = 0, rest_s_ = 0, speed_ = 0, sweep_from_ = 0, sweep_to_ = 0;
    bool moving_ = false;
};

}  // namespace stria

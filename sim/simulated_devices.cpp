#include "sim/simulated_devices.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "sim/random.h"

namespace stria {
namespace {

constexpr TimeNs kRunUpNs = 20 * kNsPerMs;  ///< at sweep speed before `from` and past `to`

class SimClock final : public Clock {
  public:
    explicit SimClock(Machine& machine) : machine_(machine) {}
    TimeNs now() override {
        const std::lock_guard lock(machine_.mutex);
        return machine_.now;
    }
    void sleep_until(TimeNs time_ns) override {
        const std::lock_guard lock(machine_.mutex);
        machine_.now = std::max(machine_.now, time_ns);
    }

  private:
    Machine& machine_;
};

class SimCamera final : public Camera {
  public:
    explicit SimCamera(Machine& machine) : machine_(machine) {}

    CameraInfo info() const override {
        const SceneSensor& sensor = machine_.scene.sensor;
        CameraInfo info;
        info.name = "simulated camera";
        info.width = machine_.scene.channel.camera.width;
        info.height = machine_.scene.channel.camera.height;
        info.bits = sensor.bits;
        info.noise = {.gain_e_per_dn = sensor.gain_e_per_dn,
                      .read_noise_e = sensor.read_noise_e,
                      .black_dn = sensor.black_dn};
        info.row_time_ns = ns_from_us(sensor.row_time_us);
        info.min_frame_period_ns = ns_from_us(sensor.min_frame_period_us);
        info.min_exposure_ns = kNsPerUs;
        info.max_exposure_ns = 10 * kNsPerSecond;
        info.timestamp_sigma_ns = ns_from_us(machine_.scene.fault.timing_jitter_us);
        return info;
    }

    Status configure(const CameraSettings& settings) override {
        const CameraInfo limits = info();
        const std::lock_guard lock(machine_.mutex);
        if (machine_.running) return Failure{"camera: cannot be configured while it runs"};
        if (settings.exposure_ns < limits.min_exposure_ns ||
            settings.exposure_ns > limits.max_exposure_ns)
            return Failure{"camera: exposure " + std::to_string(settings.exposure_ns) +
                           " ns: expected " + std::to_string(limits.min_exposure_ns) + " to " +
                           std::to_string(limits.max_exposure_ns)};
        const TimeNs shortest = std::max(settings.exposure_ns, limits.min_frame_period_ns);
        if (settings.frame_period_ns < shortest)
            return Failure{"camera: frame period " + std::to_string(settings.frame_period_ns) +
                           " ns: expected at least " + std::to_string(shortest)};
        machine_.exposure_ns = settings.exposure_ns;
        machine_.period_ns = settings.frame_period_ns;
        return {};
    }

    Status start() override {
        const std::lock_guard lock(machine_.mutex);
        if (machine_.running) return Failure{"camera: runs already"};
        machine_.running = true;
        machine_.started_at = machine_.now;
        machine_.next_sequence = 0;
        return {};
    }

    Status next_frame(Frame& frame, TimeNs deadline_ns) override {
        Machine::Shot shot;
        {
            const std::lock_guard lock(machine_.mutex);
            if (!machine_.running) return Failure{"camera: is stopped"};
            if (again_) {
                frame = *again_;
                again_.reset();
                return {};
            }
            if (Status found = find_frame(deadline_ns); !found) return found;
            describe(frame);
            shot =
                machine_.plan_shot(true_start_, machine_.frames_of_before + machine_.next_sequence);
            ++machine_.next_sequence;
        }
        machine_.render(shot, frame);
        if (is_duplicated(shot.number)) again_ = frame;
        return {};
    }

    Status stop() override {
        const std::lock_guard lock(machine_.mutex);
        if (machine_.running) machine_.frames_of_before += machine_.next_sequence;
        machine_.running = false;
        again_.reset();
        return {};
    }

  private:
    bool is_duplicated(std::int64_t number) const {
        const double share = machine_.scene.fault.duplicate_frame_probability;
        return share > 0 &&
               counter_random::uniform(machine_.seed, counter_random::kDuplicatedFrames,
                                       static_cast<std::uint64_t>(number)) < share;
    }
    bool is_dropped(std::int64_t number) const {
        const double share = machine_.scene.fault.drop_frame_probability;
        return share > 0 && counter_random::uniform(machine_.seed, counter_random::kDroppedFrames,
                                                    static_cast<std::uint64_t>(number)) < share;
    }
    /// Moves the clock to the end of the next frame that is not lost, or to the deadline.
    Status find_frame(TimeNs deadline_ns) {
        const auto late = [&] {
            machine_.now = std::max(machine_.now, deadline_ns);
            return Failure{"camera: no frame before the deadline"};
        };
        const TimeNs length = machine_.exposure_ns + machine_.readout_ns();
        const TimeNs waited = machine_.now - machine_.started_at - length;
        if (waited > 0)  // the queue held only the newest
            machine_.next_sequence =
                std::max(machine_.next_sequence, waited / machine_.period_ns - kQueuedFrames + 1);
        const std::int64_t stops = machine_.scene.fault.camera_stops_at_frame;
        while (is_dropped(machine_.frames_of_before + machine_.next_sequence))
            ++machine_.next_sequence;
        if (stops >= 0 && machine_.frames_of_before + machine_.next_sequence >= stops)
            return late();
        nominal_start_ = machine_.started_at + machine_.next_sequence * machine_.period_ns;
        const TimeNs done = nominal_start_ + length;
        if (done > deadline_ns) return late();
        machine_.now = std::max(machine_.now, done);
        const double jitter = counter_random::normal(
            machine_.seed, counter_random::kFrameJitter,
            static_cast<std::uint64_t>(machine_.frames_of_before + machine_.next_sequence));
        true_start_ = nominal_start_ + ns_from_us(machine_.scene.fault.timing_jitter_us * jitter);
        return {};
    }
    void describe(Frame& frame) const {
        const CameraModel& camera = machine_.scene.channel.camera;
        resize(frame, camera.width, camera.height, machine_.scene.sensor.bits);
        frame.camera_id = machine_.scene.channel.camera_id;
        frame.laser_id = machine_.scene.channel.laser_id;
        frame.exposure_index = 0;
        frame.laser_power = machine_.power_at(nominal_start_ + machine_.exposure_ns / 2);
        // The axis's clock runs ahead of the camera's stamps by the delay: true = stamp + delay.
        frame.exposure_start_ns =
            nominal_start_ -
            static_cast<TimeNs>(std::llround(machine_.scene.channel.axis.delay_ns));
        frame.exposure_ns = machine_.exposure_ns;
        frame.row_time_ns = ns_from_us(machine_.scene.sensor.row_time_us);
        frame.sequence = static_cast<std::uint32_t>(machine_.next_sequence);
    }

    Machine& machine_;
    TimeNs nominal_start_ = 0, true_start_ = 0;
    std::optional<Frame> again_;  ///< the last frame, to be delivered once more
};

class SimLaser final : public Laser {
  public:
    explicit SimLaser(Machine& machine) : machine_(machine) {}
    Status off() override {
        const std::lock_guard lock(machine_.mutex);
        set(0);
        return {};
    }
    Status on(float power) override {
        const std::lock_guard lock(machine_.mutex);
        if (!(power > 0 && power <= 1))
            return Failure{"laser: power " + std::to_string(power) +
                           ": expected above 0, at most 1"};
        if (machine_.now >= machine_.interlock_opens_ns())
            return Failure{"laser: the interlock is open"};
        set(power);
        return {};
    }

  private:
    void set(float power) {
        if (machine_.powers.back().power == power) return;
        // Frames not yet fetched reach back at most so far.
        const TimeNs old =
            machine_.now - (kQueuedFrames + 2) * (machine_.period_ns + machine_.readout_ns());
        while (machine_.powers.size() > 1 && machine_.powers[1].time < old)
            machine_.powers.erase(machine_.powers.begin());
        machine_.powers.push_back({machine_.now, power});
    }
    Machine& machine_;
};

class SimAxis final : public Axis {
  public:
    explicit SimAxis(Machine& machine) : machine_(machine) {}
    AxisInfo info() const override {
        const SceneAxis& axis = machine_.scene.axis;
        return {std::string("simulated ") + name_of(machine_.scene.channel.axis.kind), axis.min,
                axis.max, axis.max_speed, axis.sigma};
    }
    Status home() override {
        const std::lock_guard lock(machine_.mutex);
        machine_.motion.halt(machine_.now);
        machine_.motion.then_move(machine_.now, middle(), machine_.scene.axis.max_speed);
        machine_.now = std::max(machine_.now, machine_.motion.end_time());
        machine_.logged_until = machine_.now;
        return {};
    }
    Status move_to(double s, TimeNs deadline_ns) override {
        const std::lock_guard lock(machine_.mutex);
        if (!is_within(s)) return outside("position", s);
        machine_.motion.halt(machine_.now);
        machine_.motion.then_move(machine_.now, s, machine_.scene.axis.max_speed);
        const TimeNs end = machine_.motion.end_time();
        machine_.now = std::max(machine_.now, std::min(end, deadline_ns));
        if (end > deadline_ns) {
            machine_.motion.halt(machine_.now);
            return Failure{"axis: not at rest before the deadline"};
        }
        return {};
    }
    Status start_sweep(double from, double to, double speed) override {
        const std::lock_guard lock(machine_.mutex);
        if (!is_within(from)) return outside("from", from);
        if (!is_within(to)) return outside("to", to);
        const double fastest = machine_.scene.axis.max_speed;
        if (!(speed > 0 && speed <= fastest * (1 + 1e-9)))
            return Failure{"axis: speed " + std::to_string(speed) + ": expected above 0, at most " +
                           std::to_string(fastest)};
        if (!(std::abs(to - from) / speed <= 3600))
            return Failure{"axis: a sweep of " + std::to_string(std::abs(to - from) / speed) +
                           " s: expected at most 3600"};
        const double run_up =
            std::copysign(speed * 1e-9 * static_cast<double>(kRunUpNs), to - from);
        machine_.motion.halt(machine_.now);
        machine_.motion.then_move(machine_.now, from - run_up, fastest);
        machine_.motion.then_move(machine_.now, to + run_up, speed);
        return {};
    }
    bool is_moving() override {
        const std::lock_guard lock(machine_.mutex);
        return machine_.motion.is_moving(machine_.now);
    }
    AxisLog take_log() override {
        const std::lock_guard lock(machine_.mutex);
        AxisLog log;
        log.sigma_s = machine_.scene.axis.sigma;
        log.samples = machine_.motion.samples(machine_.logged_until, machine_.now,
                                              ns_from_us(machine_.scene.axis.log_period_us));
        for (AxisSample& sample : log.samples)
            sample.s +=
                log.sigma_s * counter_random::normal(machine_.seed, counter_random::kAxisLog,
                                                     machine_.logged_samples++);
        machine_.logged_until = machine_.now;
        return log;
    }
    Status stop() override {
        const std::lock_guard lock(machine_.mutex);
        machine_.motion.halt(machine_.now);
        return {};
    }

  private:
    double middle() const { return (machine_.scene.axis.min + machine_.scene.axis.max) / 2; }
    bool is_within(double s) const {
        const double slack = 1e-9 * (machine_.scene.axis.max - machine_.scene.axis.min);
        return s >= machine_.scene.axis.min - slack && s <= machine_.scene.axis.max + slack;
    }
    Failure outside(const char* what, double s) const {
        return {std::string("axis: ") + what + " " + std::to_string(s) + ": expected " +
                std::to_string(machine_.scene.axis.min) + " to " +
                std::to_string(machine_.scene.axis.max)};
    }
    Machine& machine_;
};

class SimInterlock final : public Interlock {
  public:
    explicit SimInterlock(Machine& machine) : machine_(machine) {}
    bool is_closed() override {
        const std::lock_guard lock(machine_.mutex);
        return machine_.now < machine_.interlock_opens_ns();
    }

  private:
    Machine& machine_;
};

}  // namespace

SimulatedDevices::SimulatedDevices(Machine& machine)
    : clock_(std::make_unique<SimClock>(machine)),
      camera_(std::make_unique<SimCamera>(machine)),
      laser_(std::make_unique<SimLaser>(machine)),
      axis_(std::make_unique<SimAxis>(machine)),
      interlock_(std::make_unique<SimInterlock>(machine)) {}

}  // namespace stria

#include "firmware/acquire/acquire.h"

#include <algorithm>
#include <exception>
#include <optional>

#include "firmware/acquire/pass_recorder.h"
#include "firmware/acquire/safe_state.h"

namespace stria {
namespace {

constexpr TimeNs kFrameGrace = kNsPerSecond;
constexpr TimeNs kMoveTime = 120 * kNsPerSecond;

/// One run and its state between the steps. A step's failure says why the run must end.
class Run {
  public:
    Run(const ScanPlan& plan, const Devices& devices, const AcquireOptions& options,
        AcquireSink& sink, const std::atomic<bool>& stop)
        : plan_(plan),
          devices_(devices),
          options_(options),
          sink_(sink),
          stop_(stop),
          camera_(devices.camera.info()),
          budget_s_(std::min(plan.max_emission_s, options.max_emission_s)) {}

    Status run() {
        if (std::string why = validate(plan_, devices_, options_); !why.empty())
            return Failure{why};
        resize(frame_, camera_.width, camera_.height, camera_.bits);
        const std::vector<SweepPass> passes = passes_of(plan_, devices_, options_);
        for (const SweepPass& pass : passes) status_.frames_expected += pass.frames;
        if (Status done = lasers_off(); !done) return done;
        if (Status done = devices_.axis.home(); !done) return done;
        if (Status done = off_frames(passes.front()); !done) return done;
        for (const SweepPass& pass : passes)
            if (Status done = sweep(pass); !done) return done;
        return {};
    }

    const AcquireStatus& status() const { return status_; }
    /// Counts the laser's time up to now; called once it is dark.
    void close_emission() {
        if (on_since_) status_.emission_s += seconds_since(*on_since_);
        on_since_.reset();
        status_.laser_on = false;
    }

  private:
    Laser& laser(std::size_t id) const {
        return id == 0 ? devices_.laser : *devices_.further_lasers[id - 1];
    }
    double seconds_since(TimeNs begin) const {
        return static_cast<double>(devices_.clock.now() - begin) * 1e-9;
    }

    Status lasers_off() {
        Status result;
        for (std::size_t id = 0; id <= devices_.further_lasers.size(); ++id)
            if (Status done = laser(id).off(); !done) result = done;
        if (result) close_emission();
        return result;
    }

    AcquireStatus status_now() const {
        AcquireStatus status = status_;
        if (on_since_) status.emission_s += seconds_since(*on_since_);
        return status;
    }

    /// What may end a run at any moment.
    Status may_go_on() const {
        if (stop_.load()) return Failure{"stopped on request"};
        if (!devices_.interlock.is_closed()) return Failure{"the interlock is open"};
        if (status_now().emission_s > budget_s_)
            return Failure{"the laser's time of " + std::to_string(budget_s_) + " s is used up"};
        return {};
    }

    Status next_frame(TimeNs period_ns) {
        const TimeNs deadline = devices_.clock.now() + 3 * period_ns + kFrameGrace;
        if (Status done = devices_.camera.next_frame(frame_, deadline); !done) return done;
        if (frame_.width == camera_.width && frame_.height == camera_.height &&
            frame_.bits == camera_.bits)
            return {};
        return Failure{"the camera gave a frame of another size or depth than it states"};
    }

    Status off_frames(const SweepPass& first) {
        if (plan_.off_frames == 0) return {};
        CameraSettings settings{first.exposure_ns, 0};
        if (plan_.off_exposure_us > 0)
            settings.exposure_ns = static_cast<TimeNs>(plan_.off_exposure_us * 1000.0);
        settings.frame_period_ns = std::max(camera_.min_frame_period_ns, settings.exposure_ns);
        Status done = devices_.camera.configure(settings);
        AxisLog log;
        for (int i = 0; done && i < plan_.off_frames; ++i) {
            const double share = i == 0 ? 0.0 : static_cast<double>(i) / (plan_.off_frames - 1);
            done =
                off_frame(plan_.from + share * (plan_.to - plan_.from), settings.frame_period_ns);
            append(log, devices_.axis.take_log());
        }
        const Status handed = sink_.take_axis_log(log);
        return done ? handed : done;
    }

    Status off_frame(double s, TimeNs period_ns) {
        if (Status may = may_go_on(); !may) return may;
        if (Status done = devices_.axis.move_to(s, devices_.clock.now() + kMoveTime); !done)
            return done;
        if (Status done = devices_.camera.start(); !done) return done;
        if (Status done = next_frame(period_ns); !done) return done;
        if (Status done = devices_.camera.stop(); !done) return done;
        frame_.laser_power = 0;
        frame_.exposure_index = 0;
        return sink_.take_frame(frame_);
    }

    /// One pass. Whatever ends it, the laser is off before anything that takes time, and log and
    /// pulses so far are handed over.
    Status sweep(const SweepPass& pass) {
        PassRecorder recorder(plan_, pass, camera_, options_);
        const AcquireStatus before = status_;
        Status result = start(pass, recorder);
        if (result) result = follow(pass, recorder, before);
        const auto then = [&](const Status& step) {
            if (result && !step) result = step;
        };
        then(lasers_off());
        sink_.take_status(status_now());
        then(devices_.axis.stop());
        then(devices_.camera.stop());
        recorder.append_log(devices_.axis.take_log());
        then(recorder.finish(sink_));
        return result;
    }

    Status start(const SweepPass& pass, PassRecorder& recorder) {
        if (Status may = may_go_on(); !may) return may;
        if (Status done = devices_.axis.move_to(pass.from, devices_.clock.now() + kMoveTime); !done)
            return done;
        recorder.append_log(devices_.axis.take_log());
        if (Status done = devices_.camera.configure({pass.exposure_ns, pass.frame_period_ns});
            !done)
            return done;
        recorder.begin_sweep(devices_.clock.now());
        if (Status done = devices_.axis.start_sweep(pass.from, pass.to, pass.speed); !done)
            return done;
        if (Status done = devices_.camera.start(); !done) return done;
        if (Status may = may_go_on(); !may) return may;
        on_since_ = devices_.clock.now();
        status_.laser_on = true;
        return laser(pass.laser_id).on(static_cast<float>(plan_.laser_power));
    }

    /// Frame after frame until the axis has passed `to`.
    Status follow(const SweepPass& pass, PassRecorder& recorder, const AcquireStatus& before) {
        using Place = PassRecorder::Place;
        while (true) {
            if (Status may = may_go_on(); !may) return may;
            if (Status done = next_frame(pass.frame_period_ns); !done) return done;
            const bool is_moving = devices_.axis.is_moving();
            recorder.append_log(devices_.axis.take_log());
            const Place place = recorder.place_of(frame_);
            if (place == Place::after) return {};
            if (place == Place::within) {
                if (Status done = recorder.take(frame_, sink_); !done) return done;
                status_.frames = before.frames + recorder.frames();
                status_.frames_dropped = before.frames_dropped + recorder.frames_dropped();
                sink_.take_status(status_now());
            }
            if (is_moving) continue;
            if (recorder.has_reached_end()) return {};
            return Failure{"the axis stopped before it reached the end of the sweep"};
        }
    }

    const ScanPlan& plan_;
    const Devices& devices_;
    const AcquireOptions& options_;
    AcquireSink& sink_;
    const std::atomic<bool>& stop_;
    const CameraInfo camera_;
    const double budget_s_;
    AcquireStatus status_;
    std::optional<TimeNs> on_since_;
    Frame frame_;
};

Status guarded(Run& run) {
    try {
        return run.run();
    } catch (const std::exception& error) {
        return Failure{error.what()};
    }
}

}  // namespace

AcquireReport run_plan(const ScanPlan& plan, const Devices& devices, const AcquireOptions& options,
                       AcquireSink& sink, const std::atomic<bool>& stop) {
    Run run(plan, devices, options, sink, stop);
    const Status done = guarded(run);
    const Status safe = make_safe(devices);
    run.close_emission();
    AcquireReport report{done.ok() && safe.ok(), "", run.status()};
    if (!done) report.reason = done.failure().message;
    if (!safe) report.reason += (done ? "" : "; ") + safe.failure().message;
    return report;
}

}  // namespace stria

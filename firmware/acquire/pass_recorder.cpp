#include "firmware/acquire/pass_recorder.h"

#include <cmath>
#include <exception>
#include <string>

namespace stria {
namespace {

/// Position at `time_ns`, later than begin_ns; after the log's end its last slope goes on, if it is
/// one of the sweep. Empty where nothing is known.
std::optional<double> expected_position(const AxisLog& log, TimeNs begin_ns, TimeNs time_ns) {
    if (time_ns < begin_ns) return std::nullopt;
    if (const auto state = position_at(log, time_ns)) return state->s;
    if (log.samples.size() < 2) return std::nullopt;
    const AxisSample& a = log.samples[log.samples.size() - 2];
    const AxisSample& b = log.samples.back();
    if (a.t_ns <= begin_ns) return std::nullopt;
    const double slope = (b.s - a.s) / static_cast<double>(b.t_ns - a.t_ns);
    return b.s + slope * static_cast<double>(time_ns - b.t_ns);
}

}  // namespace

void append(AxisLog& log, const AxisLog& more) {
    log.sigma_s = more.sigma_s;
    for (const AxisSample& sample : more.samples)
        if (log.samples.empty() || sample.t_ns > log.samples.back().t_ns)
            log.samples.push_back(sample);
}

PassRecorder::PassRecorder(const ScanPlan& plan, const SweepPass& pass, const CameraInfo& camera,
                           const AcquireOptions& options)
    : plan_(plan), pass_(pass) {
    if (plan.record == RecordWhat::frames) return;
    if (plan.mode == StripeMode::spatial)
        spatial_.emplace(camera.height, camera.noise, options.spatial);
    else if (follows_paths(plan, options))
        along_paths_.emplace(*find_paths(options, pass.laser_id), camera, options.paths);
    else
        spacetime_.emplace(camera.width, camera.height, camera.bits, camera.noise,
                           options.spacetime);
}

void PassRecorder::append_log(const AxisLog& log) { append(log_, log); }

PassRecorder::Place PassRecorder::place_of(const Frame& frame) const {
    const auto s = expected_position(log_, begin_ns_, frame.row_time(frame.height / 2));
    if (!s) return Place::before;
    const double direction = pass_.to > pass_.from ? 1.0 : -1.0;
    const double slack = 1e-6 * plan_.step;
    if (direction * (*s - pass_.from) < -slack) return Place::before;
    return direction * (*s - pass_.to) > slack ? Place::after : Place::within;
}

bool PassRecorder::has_reached_end() const {
    return !log_.samples.empty() && std::abs(log_.samples.back().s - pass_.to) <= plan_.step;
}

Status PassRecorder::take(Frame& frame, AcquireSink& sink) {
    frame.laser_id = pass_.laser_id;
    frame.laser_power = static_cast<float>(plan_.laser_power);
    frame.exposure_index = pass_.exposure_index;
    if (last_sequence_) {
        const std::uint32_t ahead = frame.sequence - *last_sequence_;  // wraps as the counter
        if (ahead == 0 || ahead > 0x7fffffffu) return {};              // delivered once more
        frames_dropped_ += ahead - 1;
    }
    last_sequence_ = frame.sequence;
    ++frames_;
    if (Status done = analyse(frame); !done)
        return Failure{"stripe analysis: " + done.failure().message};
    if (plan_.record == RecordWhat::pulses) return {};
    return sink.take_frame(frame);
}

Status PassRecorder::analyse(const Frame& frame) {
    try {
        if (spatial_) spatial_->add(frame);
        if (spacetime_) spacetime_->add(frame);
        if (along_paths_) return along_paths_->add(frame, log_);
    } catch (const std::exception& error) {
        return Failure{error.what()};
    }
    return {};
}

Status PassRecorder::finish(AcquireSink& sink) {
    if (Status done = sink.take_axis_log(log_); !done) return done;
    if (frames_ == 0 || plan_.record == RecordWhat::frames) return {};
    try {
        PulseMap map = spatial_     ? spatial_->finish()
                       : spacetime_ ? spacetime_->finish()
                                    : along_paths_->finish(log_);
        assign_axis_positions(map, log_);
        return sink.take_pulse_map(map);
    } catch (const std::exception& error) {
        return Failure{std::string("stripe analysis: ") + error.what()};
    }
}

}  // namespace stria

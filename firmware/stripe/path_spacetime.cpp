#include "firmware/stripe/path_spacetime.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "firmware/core/median.h"
#include "firmware/stripe/option_check.h"
#include "firmware/stripe/path_samples.h"
#include "firmware/stripe/row_bands.h"
#include "firmware/stripe/saturation.h"

namespace stria {
namespace {

constexpr int kMostLayings = 4;           // of a path through the place found
constexpr double kStandsStill = 0.02;     // of a width: the path is laid through its pulse
constexpr double kFarthest = 2.5;         // widths from its seed at which a pulse may be found
constexpr std::size_t kFewestSeeds = 32;  // to judge the sampling by
constexpr int kFewestSamples = 5;
constexpr double kPulseWidths = 4;  // of a pulse from end to end

}  // namespace

void PathOptions::validate() const {
    const OptionCheck require{"PathOptions"};
    seeds.validate();
    require(reach_widths >= 2 && reach_widths <= 10, "reach_widths", reach_widths, "2 to 10");
    require(min_path_px >= 0, "min_path_px", min_path_px, "0 or more");
    require(max_misfit > 0, "max_misfit", max_misfit, "above 0");
    require(max_pulse_frames >= 8 && max_pulse_frames < kMaxFitSamples, "max_pulse_frames",
            max_pulse_frames, "8 to 191");
    require(threads >= 1, "threads", threads, "1 or more");
}

PathAnalyser::PathAnalyser(PathTable table, int bits, const SensorNoise& noise,
                           const PathOptions& options)
    : table_(std::move(table)), bits_(bits), noise_(noise), options_(options) {
    options_.validate();
    if (const std::string wrong = validate(table_); !wrong.empty())
        throw std::invalid_argument(wrong);
    for (std::size_t i = 0; i < table_.valid.size(); ++i)
        if (table_.valid[i]) widest_ = std::max<double>(widest_, table_.width_s[i]);
}

void PathAnalyser::add(const Frame& frame, const AxisState& at_row_0) {
    if (frame.width != table_.image_width || frame.height != table_.image_height ||
        frame.bits != bits_)
        throw std::invalid_argument(
            "PathAnalyser: frame of " + std::to_string(frame.width) + " x " +
            std::to_string(frame.height) + ", " + std::to_string(frame.bits) + " bits: expected " +
            std::to_string(table_.image_width) + " x " + std::to_string(table_.image_height) +
            ", " + std::to_string(bits_) + " as the table of image paths");
    if (!follower_.accept(frame, options_.seeds.sequence_step)) return;
    camera_id_ = frame.camera_id;
    SpatialOptions seeds = options_.seeds;
    seeds.threads = options_.threads;
    seeds_.push_back(find_peaks(frame, noise_, seeds));
    saturated_samples_ += count_saturated(frame);
    frames_.add(frame);
    axis_.push_back(at_row_0);
    analyse_ready(false);
}

/// Axis position when row v of the frame is in the middle of its exposure.
double PathAnalyser::position(int frame, double v) const {
    const AxisState& axis = axis_[static_cast<std::size_t>(frame)];
    return axis.s + axis.ds_dt * 1e-9 * v * static_cast<double>(frames_.at(frame).row_time_ns);
}

/// Axis travel from frame to frame about frame k, signed.
double PathAnalyser::step_at(int k) const {
    const int before = std::max(k - 1, frames_.first());
    const int after = std::min(k + 1, frames_.count() - 1);
    if (after == before) return 0;
    return (axis_[static_cast<std::size_t>(after)].s - axis_[static_cast<std::size_t>(before)].s) /
           (after - before);
}

/// Frames whose pulses are wholly held, or as many as may be held: followed, then let go.
void PathAnalyser::analyse_ready(bool at_end) {
    const double reach = options_.reach_widths * widest_;
    const int most = options_.max_pulse_frames / 2;
    for (; analysed_ < frames_.count(); ++analysed_) {
        const int k = analysed_, newest = frames_.count() - 1;
        const double travel = std::abs(axis_.back().s - axis_[static_cast<std::size_t>(k)].s);
        if (!at_end && travel < reach && newest - k < most) break;
        const std::vector<Pulse>& seeds = seeds_[static_cast<std::size_t>(k)];
        std::vector<std::optional<Found>> of_seed(seeds.size());
        const int count = static_cast<int>(seeds.size());
        for_row_bands(count, std::max(1, std::min(options_.threads, count)),
                      [&](int first, int last) {
                          for (int i = first; i < last; ++i)
                              of_seed[static_cast<std::size_t>(i)] =
                                  refine(seeds[static_cast<std::size_t>(i)], k);
                      });
        for (std::size_t i = 0; i < seeds.size(); ++i) {
            if (of_seed[i]) found_.push_back(*of_seed[i]);
            const auto path = path_at(table_, seeds[i].u, seeds[i].v);
            if (path) steps_per_width_.push_back(std::abs(step_at(k)) / path->width_s);
        }
        seeds_[static_cast<std::size_t>(k)] = {};
        int oldest = std::max(frames_.first(), k + 1 - most);
        const double next_s = axis_[static_cast<std::size_t>(std::min(k + 1, newest))].s;
        while (oldest < k && std::abs(axis_[static_cast<std::size_t>(oldest)].s - next_s) >
                                 reach + 2 * std::abs(step_at(k)))
            ++oldest;
        frames_.release_before(oldest);
    }
}

/// Light along the path of the point that crosses at that place, over the axis travel in steps.
std::optional<FitSamples> PathAnalyser::samples_along(const ImagePath& path,
                                                      const Crossing& crossing, int k,
                                                      double step) const {
    FitSamples samples;
    samples.count = 0;
    samples.interpolated = true;
    const double reach = options_.reach_widths * path.width_s + std::abs(step);
    const int most = options_.max_pulse_frames / 2;
    const int last = std::min(frames_.count() - 1, k + most);
    for (int j = std::max(frames_.first(), k - most); j <= last; ++j) {
        const double d = position(j, crossing.v) - crossing.s;
        if (std::abs(d) > reach) continue;
        const double u = crossing.u + d * (path.du + 0.5 * d * path.ddu);
        const double v = crossing.v + d * (path.dv + 0.5 * d * path.ddv);
        const Frame& frame = frames_.at(j);
        if (!can_interpolate(frame, u, v)) continue;
        const InterpolatedSample sample = interpolated_sample(frame, u, v);
        if (sample.spoiled) continue;
        const auto i = static_cast<std::size_t>(samples.count++);
        samples.x[i] = (position(j, v) - crossing.s) / step;
        samples.y[i] = sample.value;
        samples.variance_share[i] = sample.variance_share;
        samples.saturated[i] = sample.saturated;
    }
    if (samples.count < kFewestSamples) return std::nullopt;
    const AxisState& axis = axis_[static_cast<std::size_t>(k)];
    samples.half_aperture =
        std::abs(0.5e-9 * axis.ds_dt / step * static_cast<double>(frames_.at(k).exposure_ns));
    return samples;
}

bool PathAnalyser::is_long_enough(const ImagePath& path) const {
    return kPulseWidths * path.width_s * std::hypot(path.du, path.dv) >= options_.min_path_px;
}

/// The pulse along that path nearest to the crossing; empty if there is none.
std::optional<PathAnalyser::Fitted> PathAnalyser::fit_along(const ImagePath& path,
                                                            const Crossing& crossing,
                                                            const Pulse& seed, int k,
                                                            double step) const {
    const auto samples = samples_along(path, crossing, k, step);
    if (!samples) return std::nullopt;
    FitStart start;
    start.amplitude = seed.amplitude;
    start.background = seed.background;
    start.width = path.width_s / std::abs(step);
    start.min_width = 0.4;
    start.max_width = 4 * start.width;
    const double smallest =
        std::max(options_.seeds.min_amplitude_dn,
                 options_.seeds.min_snr * std::sqrt(sample_variance(noise_, seed.background)));
    Fitted found{fit_pulses(*samples, noise_, (1 << bits_) - 1, start, 0.5 * smallest), 0, {}};
    const GaussianFit& fit = found.fit;
    if (!fit.converged || fit.rms_residual > options_.max_misfit * fit.amplitude[0])
        return std::nullopt;
    found.which = fit.peaks > 1 && std::abs(fit.position[1]) < std::abs(fit.position[0]) ? 1 : 0;
    const double d = fit.position[static_cast<std::size_t>(found.which)] * step;
    found.at = {crossing.u + d * (path.du + 0.5 * d * path.ddu),
                crossing.v + d * (path.dv + 0.5 * d * path.ddv), crossing.s + d};
    return found;
}

std::optional<PathAnalyser::Found> PathAnalyser::refine(const Pulse& seed, int k) const {
    const double step = step_at(k), seed_s = position(k, seed.v);
    const int row = static_cast<int>(seed.v);
    if (step == 0) return std::nullopt;
    Crossing crossing{seed.u, seed.v, seed_s};
    for (int laying = 1;; ++laying) {
        const auto path = path_at(table_, crossing.u, crossing.v);
        if (!path || !is_long_enough(*path)) {
            Pulse spatial = seed;
            spatial.flags |= kPulseSpatialFallback;
            return Found{spatial, k, row, seed_s, 0};
        }
        const auto found = fit_along(*path, crossing, seed, k, step);
        if (!found) return std::nullopt;
        const double off_seed = found->at.s - seed_s;
        if (std::abs(off_seed) > kFarthest * path->width_s + std::abs(step)) return std::nullopt;
        const double moved = std::abs(found->at.s - crossing.s);
        crossing = found->at;
        if (moved < kStandsStill * path->width_s || laying == kMostLayings)
            return Found{as_pulse(seed, found->fit, found->which, crossing, k, step), k, row,
                         crossing.s, off_seed};
    }
}

Pulse PathAnalyser::as_pulse(const Pulse& seed, const GaussianFit& fit, int which,
                             const Crossing& crossing, int k, double step) const {
    const Frame& frame = frames_.at(k);
    const double speed = axis_[static_cast<std::size_t>(k)].ds_dt;
    const double ns_per_step = std::abs(step / speed) * 1e9;
    const auto w = static_cast<std::size_t>(which);
    Pulse pulse = seed;
    pulse.u = static_cast<float>(crossing.u);
    pulse.v = static_cast<float>(crossing.v);
    pulse.t_ns =
        frame.row_time(0) +
        static_cast<TimeNs>(std::llround(crossing.v * static_cast<double>(frame.row_time_ns) +
                                         (crossing.s - position(k, crossing.v)) / speed * 1e9));
    pulse.amplitude = static_cast<float>(fit.amplitude[w]);
    pulse.width = static_cast<float>(fit.width * ns_per_step);
    pulse.background = static_cast<float>(fit.background);
    pulse.sigma = static_cast<float>(fit.sigma[w] * sigma_inflation(fit) * ns_per_step);
    pulse.chi_square = static_cast<float>(fit.chi_square);
    pulse.flags = static_cast<std::uint16_t>(seed.flags & (kPulseSaturated | kPulseImageBorder));
    if (fit.peaks > 1 || fit.unresolved) pulse.flags |= kPulseOverlapping;
    if (fit.width_at_limit) pulse.flags |= kPulseWidthOutOfRange;
    const double first = axis_.front().s, last = axis_.back().s;
    const double end = 2 * fit.width * std::abs(step);
    if (std::abs(crossing.s - first) < end || std::abs(crossing.s - last) < end)
        pulse.flags |= kPulseTouchesSequenceEnd;
    return pulse;
}

/// Of seeds of one row in neighbouring frames that led to one crossing the nearest keeps it.
void PathAnalyser::merge_twins() {
    std::stable_sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) {
        return a.row != b.row ? a.row < b.row : a.frame < b.frame;
    });
    std::vector<bool> dropped(found_.size(), false);
    for (std::size_t i = 0; i < found_.size(); ++i)
        for (std::size_t j = i + 1; j < found_.size() && found_[j].row == found_[i].row &&
                                    found_[j].frame <= found_[i].frame + 3;
             ++j) {
            const Found &a = found_[i], &b = found_[j];
            if (a.frame == b.frame) continue;
            const double step = std::abs(axis_[static_cast<std::size_t>(b.frame)].s -
                                         axis_[static_cast<std::size_t>(a.frame)].s) /
                                (b.frame - a.frame);
            if (std::abs(a.s - b.s) > 0.25 * step || std::abs(a.pulse.u - b.pulse.u) > 0.5f)
                continue;
            dropped[std::abs(a.off_seed) <= std::abs(b.off_seed) ? j : i] = true;
        }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < found_.size(); ++i)
        if (!dropped[i]) found_[kept++] = found_[i];
    found_.resize(kept);
}

PulseMap PathAnalyser::finish() {
    analyse_ready(true);
    PulseMap map;
    map.mode = StripeMode::spacetime;
    map.width = static_cast<int>(axis_.size());
    map.height = table_.image_height;
    map.camera_id = camera_id_;
    map.frames = static_cast<std::uint32_t>(axis_.size());
    map.frames_dropped = follower_.dropped();
    map.saturated_samples = saturated_samples_;
    map.undersampled = steps_per_width_.size() >= kFewestSeeds && median(steps_per_width_) > 1.0;
    if (map.undersampled) found_.clear();
    merge_twins();
    map.cell_begin.push_back(0);
    std::size_t next = 0;
    for (int v = 0; v < map.height; ++v)
        for (int k = 0; k < map.width; ++k) {
            for (; next < found_.size() && found_[next].row == v && found_[next].frame == k; ++next)
                map.pulses.push_back(found_[next].pulse);
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
        }
    return map;
}

}  // namespace stria

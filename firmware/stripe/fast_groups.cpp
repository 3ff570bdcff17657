#include "firmware/stripe/fast_groups.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "firmware/stripe/gaussian_fit.h"

namespace stria::fast {
namespace {

constexpr int kPatience = 8;  // frames that a window waits for its neighbours'
// Of a gap between frames: mean periods from which on it is one, and times a pulse's width up to
// which it does no harm.
constexpr float kWideGap = 1.5f, kGapWidths = 1.5f;
constexpr std::uint32_t kAllLanes = (1u << kLanes) - 1u;
static_assert(kSampleBins == std::tuple_size_v<SampleHistogram>);

TimeNs rounded(double ns) { return static_cast<TimeNs>(ns + std::copysign(0.5, ns)); }

bool is_empty(const GroupWindows& group, int lane) { return group.begin[lane] == group.end[lane]; }

/// The same group with one of its windows alone.
GroupWindows lane_of(const GroupWindows& group, int lane) {
    GroupWindows one{};
    one.x = group.x;
    one.y = group.y;
    one.found = true;
    one.begin[lane] = one.first = one.inner_first = group.begin[lane];
    one.end[lane] = one.past = one.inner_past = group.end[lane];
    one.background[lane] = group.background[lane];
    one.level[lane] = group.level[lane];
    return one;
}

PixelWindow window_of(const GroupWindows& group, int lane) {
    PixelWindow window;
    window.x = group.x + lane;
    window.y = group.y;
    window.begin = std::max(group.begin[lane], 0);
    window.end = group.end[lane];
    window.background = group.background[lane];
    window.level = group.level[lane];
    return window;
}

/// Copies lanes from `lane` on to the row's planes, but for their times.
template <int kCount>
void store_lanes(const FitTask& task, const PulsePlanes::Row& row, int x, int lane) {
    const auto put = [&](const float* from, float* to) {
        std::memcpy(to + x + lane, from + lane, kCount * sizeof(*to));
    };
    put(task.amplitude, row.amplitude);
    put(task.width, row.width);
    put(task.level, row.background);
    put(task.sigma, row.sigma);
    put(task.chi_square, row.chi_square);
}

}  // namespace

FrameTable::FrameTable(const FrameStore& frames, double period_ns) : first_(frames.first()) {
    for (int k = first_; k < frames.count(); ++k) {
        pixels_.push_back(frames.at(k).bytes.data());
        times_.push_back(
            static_cast<double>(frames.at(k).row_time(0) - frames.at(first_).row_time(0)) /
            period_ns);
        half_apertures_.push_back(
            static_cast<float>(0.5 * static_cast<double>(frames.at(k).exposure_ns) / period_ns));
    }
    const std::size_t count = times_.size();
    for (std::size_t i = 0; i < count; ++i)
        intervals_.push_back(static_cast<float>(
            0.5 * (times_[std::min(i + 1, count - 1)] - times_[i > 0 ? i - 1 : 0])));
    relative_.reserve(count * count);
    for (const double middle : times_)
        for (const double time : times_) relative_.push_back(static_cast<float>(time - middle));
    for (std::size_t i = 1; i < count; ++i)
        widest_gap_ = std::max(widest_gap_, times_[i] - times_[i - 1]);
}

GroupFits::GroupFits(const FitSetting& setting, PulsePlanes& planes, std::vector<RowFinds>& rows)
    : setting_(setting),
      limits_{setting.options.max_pulse_frames, setting.options.history_frames},
      table_(setting.frames, setting.period_ns),
      planes_(planes),
      rows_(rows) {
    const SensorNoise& noise = setting_.noise;
    const double read = noise.read_noise_e / noise.gain_e_per_dn;
    FitTask task;
    task.period_ns = static_cast<float>(setting_.period_ns);
    task.variance_floor = static_cast<float>(read * read + 1.0 / 12.0);
    task.variance_gain = static_cast<float>(1.0 / noise.gain_e_per_dn);
    task.black = static_cast<float>(noise.black_dn);
    task.min_snr = static_cast<float>(setting_.options.min_snr);
    task.min_amplitude_dn = static_cast<float>(setting_.options.min_amplitude_dn);
    task.max_misfit = static_cast<float>(setting_.options.max_misfit);
    one_.task = other_.task = task;
}

void GroupFits::queue(int y, const RowPlanes& row, bool all) {
    const std::size_t before = next_.size();
    int& needed = rows_[static_cast<std::size_t>(y)].needed;
    needed = std::max(needed, collect_groups(row, setting_.width, table_.end(), all ? 0 : kPatience,
                                             limits_, next_));
    for (std::size_t i = before; i < next_.size(); ++i) {
        next_[i].y = y;
        prepare(next_[i]);
    }
}

void GroupFits::queue(int y, const RowPlanes& row, const Closed& window) {
    row.raise(window.x, kFound);
    const auto waited = static_cast<std::uint8_t>(table_.end() - window.end);
    GroupWindows group{};
    group.x = window.x / kLanes * kLanes;
    group.y = y;
    const int lane = window.x - group.x;
    group.end[lane] = table_.end() - waited;
    group.begin[lane] =
        group.end[lane] - (window.last + 1 + 2 * margin_frames(window.last, limits_));
    group.background[lane] = static_cast<float>(window.background) / 256.0f;
    group.level[lane] = static_cast<float>(window.threshold) + 1.0f;
    next_.push_back(lane_of(group, lane));
    prepare(next_.back());
}

/// Windows that the sweep's beginning cuts go to the reference at once; memory is asked for the
/// samples of the others, and for their places in the planes.
void GroupFits::prepare(GroupWindows& group) {
    if (group.first <= 0) {
        group.first = group.inner_past = table_.end();
        group.past = group.inner_first = 0;
        for (int lane = 0; lane < kLanes; ++lane) {
            if (is_empty(group, lane)) continue;
            if (group.begin[lane] <= 0) {
                take_plainly(window_of(group, lane));
                group.begin[lane] = group.end[lane] = 0;
                continue;
            }
            group.first = std::min(group.first, group.begin[lane]);
            group.past = std::max(group.past, group.end[lane]);
            group.inner_first = std::max(group.inner_first, group.begin[lane]);
            group.inner_past = std::min(group.inner_past, group.end[lane]);
        }
        group.inner_past = std::max(group.inner_first, group.inner_past);
    }
    const std::size_t at =
        static_cast<std::size_t>(group.y) * static_cast<std::size_t>(setting_.width) +
        static_cast<std::size_t>(group.x);
    prefetch(group, at);
    planes_.prefetch(group.x, group.y);
}

/// Neighbouring groups share lines of the cache: what was asked for is not asked for again, nor
/// what has just been read.
void GroupFits::prefetch(const GroupWindows& group, std::size_t at) {
    const auto line = reinterpret_cast<std::uintptr_t>(*table_.pixels(table_.first()) + at) /
                      static_cast<std::uintptr_t>(kPadding);
    if (line != asked_.line) asked_ = {line, 0, 0};
    const int past = std::min(group.past, setting_.fresh);
    if (group.first >= past) return;
    for (int k = group.first; k < past; ++k)
        if (k < asked_.first || k >= asked_.past) __builtin_prefetch(*table_.pixels(k) + at, 0, 2);
    asked_ = {line, group.first, past};
}

void GroupFits::fit_queued() {
    const GroupWindows* waiting = nullptr;  // for a second one
    for (const GroupWindows& group : queue_) {
        if (group.first >= group.past) continue;
        if (group.past - group.first > kMaxFitSamples) {
            // So long that no fit holds the frames of all windows: one after the other.
            for (int lane = 0; lane < kLanes; ++lane)
                if (!is_empty(group, lane)) {
                    const GroupWindows alone = lane_of(group, lane);
                    fit(alone, nullptr);
                }
        } else if (waiting == nullptr) {
            waiting = &group;
        } else {
            fit(*waiting, &group);
            waiting = nullptr;
        }
    }
    if (waiting != nullptr) fit(*waiting, nullptr);
    queue_.clear();
}

void GroupFits::take_plainly(const PixelWindow& window) {
    RowFinds& row = rows_[static_cast<std::size_t>(window.y)];
    ++row.windows.all;
    ++row.windows.by_reference;
    const PulseLevels levels = pulse_levels(setting_.noise, setting_.options, window.background);
    note_effective_samples(effective_samples(setting_.frames, window, levels), row.effective);
    fit_window(setting_.frames, window, setting_.noise, setting_.options, row.others);
}

void GroupFits::fit(const GroupWindows& group, const GroupWindows* other) {
    fill(one_, group);
    if (other != nullptr) fill(other_, *other);
    fit_groups(one_.task, other != nullptr ? &other_.task : nullptr);
    doubt_pulses_in_gaps(one_.task);
    settle(one_);
    if (other == nullptr) return;
    doubt_pulses_in_gaps(other_.task);
    settle(other_);
}

void GroupFits::fill(Work& work, const GroupWindows& group) const {
    FitTask& task = work.task;
    const int length = group.past - group.first;
    work.middle = group.first + length / 2;
    const double* times = table_.times(group.first);
    task.windows = &group;
    task.x = table_.times(group.first, work.middle);
    task.interval = table_.intervals(group.first);
    task.period = static_cast<float>((times[length - 1] - times[0]) / (length - 1));
    task.widest_gap = std::max(task.period, static_cast<float>(table_.widest_gap()));
    task.half_aperture = table_.half_aperture(group.first);
    task.max_width = 0.5f * static_cast<float>(setting_.options.max_pulse_frames) * task.period;
    task.samples = table_.pixels(group.first);
    task.offset = static_cast<std::size_t>(group.y) * static_cast<std::size_t>(setting_.width) +
                  static_cast<std::size_t>(group.x);
    const std::size_t size =
        static_cast<std::size_t>(setting_.width) * static_cast<std::size_t>(setting_.height);
    if (task.offset + kLanes > size) copy_samples(work, size);
}

/// Behind the last pixel there is nothing to load: zeros stand in for it.
void GroupFits::copy_samples(Work& work, std::size_t size) {
    FitTask& task = work.task;
    const auto length = static_cast<std::size_t>(task.windows->past - task.windows->first);
    work.copies.assign(length * kLanes, 0);
    work.copied.clear();
    for (std::size_t i = 0; i < length; ++i) {
        std::uint8_t* copy = work.copies.data() + i * kLanes;
        std::copy(task.samples[i] + task.offset, task.samples[i] + size, copy);
        work.copied.push_back(copy);
    }
    task.samples = work.copied.data();
    task.offset = 0;
}

/// Beside a gap between frames that is wide against a pulse there may be another place and width
/// for it, as likely: such pulses are the reference's.
void GroupFits::doubt_pulses_in_gaps(FitTask& task) const {
    // A per cent for the rounding of the kernels' times.
    if (task.widest_gap < 0.99f * kWideGap * task.period) return;
    const int length = task.windows->past - task.windows->first;
    for (int i = 1; i < length; ++i) {
        const float low = task.x[i - 1], high = task.x[i], gap = high - low;
        if (gap < kWideGap * task.period) continue;
        for (std::uint32_t bits = task.pulses; bits != 0; bits &= bits - 1) {
            const int lane = std::countr_zero(bits);
            const float width = task.width[lane] / task.period_ns;
            const float place = task.position[lane];
            if (gap < kGapWidths * width || place < low - gap || place > high + gap) continue;
            task.pulses &= ~(1u << lane);
            task.unsure |= 1u << lane;
        }
    }
}

void GroupFits::add_effective(SampleHistogram& sum) const {
    for (std::size_t bin = 0; bin < kSampleBins; ++bin)
        for (const auto& of_lanes : effective_) sum[bin] += of_lanes[bin];
}

void GroupFits::settle(const Work& work) {
    const GroupWindows& group = *work.task.windows;
    RowFinds& row = rows_[static_cast<std::size_t>(group.y)];
    row.windows.all += static_cast<unsigned>(std::popcount(work.task.lanes));
    for (std::size_t lane = 0; lane < kLanes; ++lane)
        ++effective_[lane % 4][static_cast<std::size_t>(work.task.effective_bin[lane])];
    if (work.task.pulses != 0) store(work, setting_.frames.at(work.middle).row_time(group.y));
    for (std::uint32_t bits = work.task.unsure; bits != 0; bits &= bits - 1) {
        ++row.windows.by_reference;
        fit_window(setting_.frames, window_of(group, std::countr_zero(bits)), setting_.noise,
                   setting_.options, row.others);
    }
}

/// Puts the clean pulses into the planes; a pixel's second one among the row's others.
void GroupFits::store(const Work& work, TimeNs middle) {
    const FitTask& task = work.task;
    const int x = task.windows->x, y = task.windows->y;
    const auto time_of = [&](int lane) {
        return middle + rounded(static_cast<double>(task.position[lane]) * setting_.period_ns);
    };
    const PulsePlanes::Row row = planes_.row(y);
    const Frame& frame = setting_.frames.at(work.middle);
    const bool usual =
        frame.laser_id == setting_.laser_id && frame.exposure_index == setting_.exposure_index;
    std::uint32_t free = 0;
    for (int lane = 0; lane < kLanes; ++lane) free |= (row.width[x + lane] == 0 ? 1u : 0u) << lane;
    if (usual && (task.pulses & free) == kAllLanes) {
        // One by one: a copy would wait for its parts.
        for (int lane = 0; lane < kLanes; ++lane) row.t_ns[x + lane] = time_of(lane);
        store_lanes<kLanes>(task, row, x, 0);
        return;
    }
    for (std::uint32_t bits = task.pulses; bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        if (usual && (free >> lane & 1u) != 0) {
            row.t_ns[x + lane] = time_of(lane);
            store_lanes<1>(task, row, x, lane);
        } else {
            rows_[static_cast<std::size_t>(y)].others.push_back(
                pulse_of(work, lane, time_of(lane)));
        }
    }
}

Pulse GroupFits::pulse_of(const Work& work, int lane, TimeNs t_ns) const {
    const FitTask& task = work.task;
    const Frame& frame = setting_.frames.at(work.middle);
    Pulse pulse;
    pulse.u = static_cast<float>(task.windows->x + lane);
    pulse.v = static_cast<float>(task.windows->y);
    pulse.t_ns = t_ns;
    pulse.amplitude = task.amplitude[lane];
    pulse.width = task.width[lane];
    pulse.background = task.level[lane];
    pulse.sigma = task.sigma[lane];
    pulse.chi_square = task.chi_square[lane];
    pulse.laser_id = frame.laser_id;
    pulse.exposure_index = frame.exposure_index;
    return pulse;
}

}  // namespace stria::fast

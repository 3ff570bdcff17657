#include "firmware/stripe/fast_groups.h"

#include <algorithm>
#include <bit>
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

TimeNs rounded(double ns) { return static_cast<TimeNs>(ns + (ns < 0 ? -0.5 : 0.5)); }

bool is_empty(const GroupWindows& group, int lane) { return group.begin[lane] == group.end[lane]; }

/// The same group with one of its windows alone.
GroupWindows lane_of(const GroupWindows& group, int lane) {
    GroupWindows one{};
    one.x = group.x;
    one.y = group.y;
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

}  // namespace

FrameTable::FrameTable(const FrameStore& frames, double period_ns) : first_(frames.first()) {
    for (int k = first_; k < frames.count(); ++k) {
        pixels_.push_back(frames.at(k).bytes.data());
        times_.push_back(
            static_cast<double>(frames.at(k).row_time(0) - frames.at(first_).row_time(0)) /
            period_ns);
    }
    const std::size_t count = times_.size();
    for (std::size_t i = 0; i < count; ++i)
        intervals_.push_back(static_cast<float>(
            0.5 * (times_[std::min(i + 1, count - 1)] - times_[i > 0 ? i - 1 : 0])));
}

GroupFits::GroupFits(const FitSetting& setting, PulsePlanes& planes, std::vector<RowFinds>& rows)
    : setting_(setting),
      limits_{setting.options.max_pulse_frames, setting.options.history_frames},
      table_(setting.frames, setting.period_ns),
      planes_(planes),
      rows_(rows),
      times_(kMaxFitSamples) {
    const SensorNoise& noise = setting_.noise;
    const double read = noise.read_noise_e / noise.gain_e_per_dn;
    task_.x = times_.data();
    task_.period_ns = static_cast<float>(setting_.period_ns);
    task_.variance_floor = static_cast<float>(read * read + 1.0 / 12.0);
    task_.variance_gain = static_cast<float>(1.0 / noise.gain_e_per_dn);
    task_.black = static_cast<float>(noise.black_dn);
    task_.min_snr = static_cast<float>(setting_.options.min_snr);
    task_.min_amplitude_dn = static_cast<float>(setting_.options.min_amplitude_dn);
    task_.max_misfit = static_cast<float>(setting_.options.max_misfit);
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

void GroupFits::queue(int y, const Closed& window) {
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
    for (int k = group.first; k < group.past; ++k) __builtin_prefetch(*table_.pixels(k) + at);
    planes_.prefetch(group.x, group.y);
}

void GroupFits::fit_queued() {
    for (const GroupWindows& group : queue_) fit(group);
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

void GroupFits::fit(const GroupWindows& group) {
    if (group.first >= group.past) return;
    if (group.past - group.first > kMaxFitSamples) {
        fit_lanes_apart(group);
        return;
    }
    fill_task(group);
    fit_group(task_);
    doubt_pulses_in_gaps();
    settle(group);
}

/// Windows so long that no fit holds the frames of all of them.
void GroupFits::fit_lanes_apart(const GroupWindows& group) {
    for (int lane = 0; lane < kLanes; ++lane)
        if (!is_empty(group, lane)) fit(lane_of(group, lane));
}

void GroupFits::fill_task(const GroupWindows& group) {
    const int length = group.past - group.first;
    middle_ = group.first + length / 2;
    const double* times = table_.times(group.first);
    const double middle = *table_.times(middle_);
    for (int i = 0; i < length; ++i)
        times_[static_cast<std::size_t>(i)] = static_cast<float>(times[i] - middle);

    task_.windows = &group;
    task_.interval = table_.intervals(group.first);
    task_.period = static_cast<float>((times[length - 1] - times[0]) / (length - 1));
    task_.half_aperture =
        static_cast<float>(0.5 * static_cast<double>(setting_.frames.at(group.first).exposure_ns) /
                           setting_.period_ns);
    task_.max_width = 0.5f * static_cast<float>(setting_.options.max_pulse_frames) * task_.period;
    task_.samples = table_.pixels(group.first);
    task_.offset = static_cast<std::size_t>(group.y) * static_cast<std::size_t>(setting_.width) +
                   static_cast<std::size_t>(group.x);
    const std::size_t size =
        static_cast<std::size_t>(setting_.width) * static_cast<std::size_t>(setting_.height);
    if (task_.offset + kLanes > size) copy_samples(size);
}

/// Behind the last pixel there is nothing to load: zeros stand in for it.
void GroupFits::copy_samples(std::size_t size) {
    const auto length = static_cast<std::size_t>(task_.windows->past - task_.windows->first);
    copies_.assign(length * kLanes, 0);
    copied_.clear();
    for (std::size_t i = 0; i < length; ++i) {
        std::uint8_t* copy = copies_.data() + i * kLanes;
        std::copy(task_.samples[i] + task_.offset, task_.samples[i] + size, copy);
        copied_.push_back(copy);
    }
    task_.samples = copied_.data();
    task_.offset = 0;
}

/// Beside a gap between frames that is wide against a pulse there may be another place and width
/// for it, as likely: such pulses are the reference's.
void GroupFits::doubt_pulses_in_gaps() {
    const int length = task_.windows->past - task_.windows->first;
    for (int i = 1; i < length; ++i) {
        const float low = task_.x[i - 1], high = task_.x[i], gap = high - low;
        if (gap < kWideGap * task_.period) continue;
        for (std::uint32_t bits = task_.pulses; bits != 0; bits &= bits - 1) {
            const int lane = std::countr_zero(bits);
            const float width = task_.width[lane] / task_.period_ns;
            const float place = task_.position[lane];
            if (gap < kGapWidths * width || place < low - gap || place > high + gap) continue;
            task_.pulses &= ~(1u << lane);
            task_.unsure |= 1u << lane;
        }
    }
}

void GroupFits::settle(const GroupWindows& group) {
    RowFinds& row = rows_[static_cast<std::size_t>(group.y)];
    row.windows.all += static_cast<unsigned>(std::popcount(task_.lanes));
    for (const std::int32_t bin : task_.effective_bin)
        if (bin < kSampleBins) ++row.effective[static_cast<std::size_t>(bin)];
    if (task_.pulses != 0) store(group, setting_.frames.at(middle_).row_time(group.y));
    for (std::uint32_t bits = task_.unsure; bits != 0; bits &= bits - 1) {
        ++row.windows.by_reference;
        fit_window(setting_.frames, window_of(group, std::countr_zero(bits)), setting_.noise,
                   setting_.options, row.others);
    }
}

/// Puts the clean pulses into the planes; a pixel's second one among the row's others.
void GroupFits::store(const GroupWindows& group, TimeNs middle) {
    TimeNs times[kLanes];
    for (int lane = 0; lane < kLanes; ++lane)
        times[lane] =
            middle + rounded(static_cast<double>(task_.position[lane]) * setting_.period_ns);
    const PulsePlanes::Row row = planes_.row(group.y);
    const Frame& frame = setting_.frames.at(middle_);
    const bool usual =
        frame.laser_id == setting_.laser_id && frame.exposure_index == setting_.exposure_index;
    const float* const taken = row.width + group.x;
    std::uint32_t free = 0;
    for (int lane = 0; lane < kLanes; ++lane) free |= (taken[lane] == 0 ? 1u : 0u) << lane;
    if (usual && (task_.pulses & free) == kAllLanes) {
        store_lanes<kLanes>(row, group.x, 0, times);
        return;
    }
    for (std::uint32_t bits = task_.pulses; bits != 0; bits &= bits - 1) {
        const int lane = std::countr_zero(bits);
        if (usual && (free >> lane & 1u) != 0)
            store_lanes<1>(row, group.x, lane, times);
        else
            rows_[static_cast<std::size_t>(group.y)].others.push_back(
                pulse_of(group, lane, times[lane]));
    }
}

template <int kCount>
void GroupFits::store_lanes(const PulsePlanes::Row& row, int x, int lane,
                            const TimeNs* times) const {
    const auto put = [&](const auto* from, auto* to) {
        std::memcpy(to + x + lane, from + lane, kCount * sizeof(*to));
    };
    put(times, row.t_ns);
    put(task_.amplitude, row.amplitude);
    put(task_.width, row.width);
    put(task_.level, row.background);
    put(task_.sigma, row.sigma);
    put(task_.chi_square, row.chi_square);
}

Pulse GroupFits::pulse_of(const GroupWindows& group, int lane, TimeNs t_ns) const {
    const Frame& frame = setting_.frames.at(middle_);
    Pulse pulse;
    pulse.u = static_cast<float>(group.x + lane);
    pulse.v = static_cast<float>(group.y);
    pulse.t_ns = t_ns;
    pulse.amplitude = task_.amplitude[lane];
    pulse.width = task_.width[lane];
    pulse.background = task_.level[lane];
    pulse.sigma = task_.sigma[lane];
    pulse.chi_square = task_.chi_square[lane];
    pulse.laser_id = frame.laser_id;
    pulse.exposure_index = frame.exposure_index;
    return pulse;
}

}  // namespace stria::fast

#include "firmware/stripe/pixel_tracker.h"

#include <algorithm>
#include <bit>

namespace stria {
namespace {

constexpr int kBlock = 64;  // pixels looked at together

}  // namespace

template <typename T>
PixelTracker<T>::PixelTracker(int width, int y, int full_scale, const SensorNoise& noise,
                              const SpacetimeOptions& options)
    : width_(width),
      y_(y),
      full_scale_(full_scale),
      noise_(noise),
      options_(options),
      levels_(std::bit_width(static_cast<unsigned>(full_scale)), noise, options.min_snr,
              options.min_amplitude_dn),
      background_(static_cast<std::size_t>(width)),
      threshold_(static_cast<std::size_t>(width)) {}

template <typename T>
void PixelTracker<T>::advance(const FrameStore& frames, int begin, int end) {
    if (!started_) set_backgrounds(frames, begin, end);
    started_ = true;
    for (int k = begin; k < end; ++k) {
        find_above(row_of<T>(frames.at(k), y_));
        if (!above_.empty() || !open_.empty()) follow(frames, k);
    }
    update_backgrounds(frames, begin, end);
    set_thresholds();
}

/// Right for all but those pixels on which the stripe stays during the whole batch, which the
/// falling light corrects later.
template <typename T>
void PixelTracker<T>::set_backgrounds(const FrameStore& frames, int begin, int end) {
    const T* first = row_of<T>(frames.at(begin), y_);
    std::vector<DetectionLevels::FirstSamples> samples;
    for (int x = 0; x < width_; ++x) samples.emplace_back(first[x]);
    for (int k = begin + 1; k < end; ++k) {
        const T* row = row_of<T>(frames.at(k), y_);
        for (int x = 0; x < width_; ++x) samples[x].add(row[x]);
    }
    for (int x = 0; x < width_; ++x) background_[x] = levels_.first(samples[x]);
    set_thresholds();
}

template <typename T>
void PixelTracker<T>::set_thresholds() {
    for (int x = 0; x < width_; ++x)
        threshold_[x] = static_cast<T>(levels_.threshold(background_[x]));
}

/// The tight loop: nearly all blocks of a row hold nothing above its threshold.
template <typename T>
void PixelTracker<T>::find_above(const T* row) {
    above_.clear();
    const T* threshold = threshold_.data();
    const auto full = static_cast<T>(full_scale_);
    for (int begin = 0; begin < width_; begin += kBlock) {
        const int end = std::min(begin + kBlock, width_);
        T any = 0, highest = 0;
        for (int x = begin; x < end; ++x) {
            any = static_cast<T>(any | (row[x] > threshold[x] ? T{1} : T{0}));
            highest = std::max(highest, row[x]);
        }
        if (highest == full)
            saturated_samples +=
                static_cast<std::uint32_t>(std::count(row + begin, row + end, full));
        if (any == 0) continue;
        for (int x = begin; x < end; ++x)
            if (row[x] > threshold[x]) above_.push_back(x);
    }
}

/// Joins the pixels above with the windows that are open, both ascending in x.
template <typename T>
void PixelTracker<T>::follow(const FrameStore& frames, int k) {
    still_open_.clear();
    std::size_t a = 0;
    const auto open_new = [&](int x) { still_open_.push_back({x, k, k}); };
    for (Open open : open_) {
        while (a < above_.size() && above_[a] < open.x) open_new(above_[a++]);
        const bool above = a < above_.size() && above_[a] == open.x;
        if (above) {
            open.last_above = k;
            ++a;
        }
        if (k - open.first_above >= options_.max_pulse_frames) {
            // No pulse but another light: the pixel starts anew from here.
            background_[open.x] = std::uint32_t{row_of<T>(frames.at(k), y_)[open.x]} << 8;
            continue;
        }
        const int tail = std::min(open.lead(), options_.history_frames);
        if (!above && k - open.last_above >= tail)
            close(frames, open, k + 1, false);
        else
            still_open_.push_back(open);
    }
    while (a < above_.size()) open_new(above_[a++]);
    std::swap(open_, still_open_);
}

template <typename T>
void PixelTracker<T>::close(const FrameStore& frames, const Open& open, int end,
                            bool at_sequence_end) {
    ++windows;
    PixelWindow window;
    window.x = open.x;
    window.y = y_;
    window.begin = std::max(
        {open.first_above - std::min(open.lead(), options_.history_frames), frames.first(), 0});
    window.end = end;
    window.background = static_cast<float>(background_[open.x]) / 256.0f;
    window.at_sequence_end = at_sequence_end;
    window.level = static_cast<float>(threshold_[open.x]) + 1.0f;
    const PulseLevels levels = pulse_levels(noise_, options_, window.background);
    note_effective_samples(effective_samples(frames, window, levels), effective);
    fit_window(frames, window, noise_, options_, pulses);
}

template <typename T>
void PixelTracker<T>::finish(const FrameStore& frames) {
    for (const Open& open : open_) close(frames, open, frames.count(), true);
    open_.clear();
}

template <typename T>
int PixelTracker<T>::oldest_needed(int otherwise) const {
    int oldest = otherwise;
    for (const Open& open : open_)
        oldest = std::min(oldest, open.first_above - options_.history_frames);
    return std::max(oldest, 0);
}

/// Towards the batch's mean where nothing is open; down at once where the light has fallen.
template <typename T>
void PixelTracker<T>::update_backgrounds(const FrameStore& frames, int begin, int end) {
    thread_local std::vector<std::uint32_t> sum;
    thread_local std::vector<std::uint32_t> kept;
    sum.assign(static_cast<std::size_t>(width_), 0);
    for (int k = begin; k < end; ++k) {
        const T* row = row_of<T>(frames.at(k), y_);
        for (int x = 0; x < width_; ++x) sum[x] += row[x];
    }
    kept.clear();
    for (const Open& open : open_) kept.push_back(background_[open.x]);
    for (int x = 0; x < width_; ++x)
        background_[x] = levels_.follow(background_[x], sum[x], end - begin);
    for (std::size_t i = 0; i < open_.size(); ++i) background_[open_[i].x] = kept[i];
}

template class PixelTracker<std::uint8_t>;
template class PixelTracker<std::uint16_t>;

}  // namespace stria

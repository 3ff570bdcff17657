#include "firmware/stripe/row_peaks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "firmware/stripe/gaussian_fit.h"

namespace stria {
namespace {

constexpr float kDetectionSnr = 3.5f;  // of box means; the fit applies the caller's min_snr
constexpr double kFwhmPerSigma = 2.3548;

/// a or b, by their bits: the compiler keeps what might trap behind a branch of its own otherwise,
/// and then does not vectorise.
template <typename T>
T select(bool condition, T a, T b) {
    const std::int32_t mask = -static_cast<std::int32_t>(condition);
    return std::bit_cast<T>((std::bit_cast<std::int32_t>(a) & mask) |
                            (std::bit_cast<std::int32_t>(b) & ~mask));
}

/// Grows as a matched filter's signal-to-noise.
float strength(const Pulse& p) { return p.amplitude * std::sqrt(p.width); }

}  // namespace

RowPeakFinder::RowPeakFinder(int width, int full_scale, const SensorNoise& noise,
                             const SpatialOptions& options)
    : width_(width), full_scale_(full_scale), noise_(noise), options_(options) {
    // Boxes of about two widths, each half as large again as the last, up to the widest stripe.
    const double widest = std::min(2.0 * options.max_width_px, width / 3.0);
    for (double box = 1; box <= std::max(widest, 2.0); box = std::ceil(1.5 * box))
        boxes_.push_back(static_cast<int>(box));
    const auto n = static_cast<std::size_t>(width);
    values_.resize(n);
    sums_.resize(n + 1);
    answer_.resize(n);
    background_.resize(n);
    box_.resize(n);
}

template <typename T>
void RowPeakFinder::find(const T* row, std::vector<Pulse>& peaks) {
    T lowest = row[0], highest = row[0];
    for (int x = 0; x < width_; ++x) {
        lowest = std::min(lowest, row[x]);
        highest = std::max(highest, row[x]);
    }
    if (highest - lowest < 0.5 * options_.min_amplitude_dn) return;  // nothing can stand out

    for (int x = 0; x < width_; ++x) values_[x] = static_cast<float>(row[x]);
    std::int32_t sum = 0;  // at most 16384 x 65535
    for (int x = 0; x < width_; ++x) sums_[x + 1] = sum += row[x];
    detect();
    choose_candidates();
    const std::size_t first = peaks.size();
    places_.clear();
    for (const Candidate& candidate : candidates_)
        if (!is_covered(candidate.x, peaks, first)) fit(candidate, peaks, first);
    move_to_places(peaks, first);
    const auto begin = peaks.begin() + static_cast<std::ptrdiff_t>(first);
    std::stable_sort(begin, peaks.end(),
                     [](const Pulse& a, const Pulse& b) { return strength(a) > strength(b); });
    const auto most = static_cast<std::size_t>(options_.max_peaks_per_row);
    if (peaks.size() > first + most) peaks.resize(first + most);
}

void RowPeakFinder::detect() {
    std::fill(answer_.begin(), answer_.end(), 0.0f);
    for (const int box : boxes_) detect_at(box);
}

/// Mean of `box` samples against the brighter of the two sides (each as long as the box, at least 3
/// px, a box and at least 2 px away): a stripe stands out from both sides, the edge of a bright
/// thing from one.
void RowPeakFinder::detect_at(int box) {
    const int side = std::max(box, 3), gap = std::max(box, 2);
    const int left = (box - 1) / 2;  // the box covers x - left .. x - left + box - 1
    const int reach_left = left + gap + side, reach_right = box - left + gap + side;
    const int first = std::min(reach_left, width_);
    const int last = std::max(width_ - reach_right + 1, first);
    for (int x = 0; x < first; ++x)
        judge(x, box, mean_or_dark(x - reach_left, side), mean_or_dark(x + box - left + gap, side));
    for (int x = last; x < width_; ++x)
        judge(x, box, mean_or_dark(x - reach_left, side), mean_or_dark(x + box - left + gap, side));

    const auto read_dn = noise_.read_noise_e / noise_.gain_e_per_dn;
    const auto floor = static_cast<float>(read_dn * read_dn + 1.0 / 12.0);
    const auto gain = static_cast<float>(1.0 / noise_.gain_e_per_dn);
    const auto black = static_cast<float>(noise_.black_dn);
    const auto least = static_cast<float>(0.5 * options_.min_amplitude_dn);
    const float per_box = 1.0f / static_cast<float>(box);
    const float per_side = 1.0f / static_cast<float>(side);
    const float spread = per_box + per_side;
    const std::int32_t* sums = sums_.data();
    float* answers = answer_.data();
    float* backgrounds = background_.data();
    int* boxes = box_.data();
    for (int x = first; x < last; ++x) {  // branchless, so that it is vectorised
        const int begin = x - left, end = begin + box;
        const float mean = static_cast<float>(sums[end] - sums[begin]) * per_box;
        const float on_left =
            static_cast<float>(sums[begin - gap] - sums[begin - gap - side]) * per_side;
        const float on_right =
            static_cast<float>(sums[end + gap + side] - sums[end + gap]) * per_side;
        const float brighter = select(on_left > on_right, on_left, on_right);
        const float light = select(brighter > black, brighter - black, 0.0f);
        const float contrast = select(mean > brighter + least, mean - brighter, 0.0f);
        const float answer = contrast * contrast / ((floor + gain * light) * spread);
        const bool better = answer > answers[x];
        answers[x] = select(better, answer, answers[x]);
        backgrounds[x] = select(better, 0.5f * (on_left + on_right), backgrounds[x]);
        boxes[x] = select(better, box, boxes[x]);
    }
}

/// Mean of the samples from `begin` on; -1 where the border cuts them off.
float RowPeakFinder::mean_or_dark(int begin, int count) const {
    if (begin < 0 || begin + count > width_) return -1.0f;
    return static_cast<float>(sums_[begin + count] - sums_[begin]) / static_cast<float>(count);
}

/// What the loop above does, where the border cuts off a side, which the other then stands for.
void RowPeakFinder::judge(int x, int box, float on_left, float on_right) {
    const float brighter = std::max(on_left, on_right);
    if (brighter < 0) return;
    const int begin = std::max(x - (box - 1) / 2, 0);
    const int end = std::min(x - (box - 1) / 2 + box, width_);
    const float mean = static_cast<float>(sums_[end] - sums_[begin]) / static_cast<float>(box);
    const auto least = static_cast<float>(0.5 * options_.min_amplitude_dn);
    if (mean <= brighter + least) return;
    const float spread =
        1.0f / static_cast<float>(box) + 1.0f / static_cast<float>(std::max(box, 3));
    const float contrast = mean - brighter;
    const float answer =
        contrast * contrast / (static_cast<float>(sample_variance(noise_, brighter)) * spread);
    if (answer <= answer_[x]) return;
    answer_[x] = answer;
    background_[x] = on_left < 0 || on_right < 0 ? brighter : 0.5f * (on_left + on_right);
    box_[x] = box;
}

/// Greatest answers within a box of each other, the strongest few of them.
void RowPeakFinder::choose_candidates() {
    candidates_.clear();
    for (int x = 0; x < width_; ++x) {
        if (answer_[x] < kDetectionSnr * kDetectionSnr) continue;
        const int reach = box_[x];
        bool greatest = true;
        for (int k = std::max(x - reach, 0); k <= std::min(x + reach, width_ - 1) && greatest; ++k)
            greatest = answer_[k] < answer_[x] || (answer_[k] == answer_[x] && k >= x);
        if (greatest) candidates_.push_back({x, box_[x], answer_[x], background_[x]});
    }
    std::stable_sort(candidates_.begin(), candidates_.end(),
                     [](const Candidate& a, const Candidate& b) { return a.answer > b.answer; });
    const auto most = static_cast<std::size_t>(2 * options_.max_peaks_per_row + 2);
    if (candidates_.size() > most) candidates_.resize(most);
}

/// True on the flanks of a stripe that is already known.
bool RowPeakFinder::is_covered(int x, const std::vector<Pulse>& peaks, std::size_t first) const {
    return std::any_of(
        peaks.begin() + static_cast<std::ptrdiff_t>(first), peaks.end(),
        [&](const Pulse& p) { return std::abs(p.u - static_cast<float>(x)) < 3 * p.width + 1; });
}

void RowPeakFinder::fit(const Candidate& candidate, std::vector<Pulse>& peaks, std::size_t first) {
    // Start: highest sample near the candidate, and the width at half its height.
    int top = candidate.x;
    for (int x = std::max(candidate.x - candidate.box, 0);
         x <= std::min(candidate.x + candidate.box, width_ - 1); ++x)
        if (values_[x] > values_[top]) top = x;
    const float half = 0.5f * (values_[top] + candidate.background);
    int low = top, high = top;
    while (low > 0 && values_[low - 1] > half) --low;
    while (high < width_ - 1 && values_[high + 1] > half) ++high;
    FitStart start;
    start.min_width = options_.min_width_px;
    start.max_width = 1.5 * options_.max_width_px;
    start.width = std::clamp((high - low + 1) / kFwhmPerSigma, 0.6, options_.max_width_px);
    start.position = 0.5 * (low + high);
    start.background = candidate.background;
    start.amplitude = values_[top] - candidate.background;

    const int reach = static_cast<int>(std::ceil(4.0 * start.width)) + 2;
    const double noise_dn = std::sqrt(sample_variance(noise_, candidate.background));
    const auto raised =
        static_cast<float>(candidate.background + std::max(4.0 * noise_dn, 0.1 * start.amplitude));
    int begin = std::max(static_cast<int>(start.position) - reach, 0);
    int end = std::min(static_cast<int>(std::ceil(start.position)) + reach + 1, width_);
    // A window must not end on the flank of a neighbour: then that one is fitted along.
    const int most = std::min(5 * reach, kMaxFitSamples);
    while (begin > 0 && values_[begin] > raised && end - begin < most) --begin;
    while (end < width_ && values_[end - 1] > raised && end - begin < most) ++end;
    FitSamples samples;
    samples.count = std::min(end - begin, kMaxFitSamples);
    samples.half_aperture = 0.5;
    for (int i = 0; i < samples.count; ++i) {
        samples.x[i] = begin + i;
        samples.y[i] = values_[begin + i];
        samples.saturated[i] = values_[begin + i] >= static_cast<float>(full_scale_);
    }
    const double smallest = std::max(options_.min_amplitude_dn, options_.min_snr * noise_dn);
    const GaussianFit fit = fit_pulses(samples, noise_, full_scale_, start, smallest);
    if (!fit.converged || fit.width > options_.max_width_px) return;
    if (fit.rms_residual > options_.max_misfit * fit.amplitude[0]) return;

    bool any_saturated = false;
    for (int i = 0; i < samples.count; ++i) any_saturated |= samples.saturated[i] != 0;
    for (int k = 0; k < fit.peaks; ++k) {
        const double noise_here = std::sqrt(sample_variance(noise_, fit.background));
        if (sampled_amplitude(fit, k, samples.half_aperture) <
            std::max(options_.min_amplitude_dn, options_.min_snr * noise_here))
            continue;
        if (fit.position[k] < -0.5 || fit.position[k] > width_ - 0.5) continue;
        const bool known = std::any_of(
            peaks.begin() + static_cast<std::ptrdiff_t>(first), peaks.end(), [&](const Pulse& p) {
                return std::abs(p.u - fit.position[k]) < std::max<double>(p.width, fit.width);
            });
        if (known) continue;
        Pulse pulse;
        pulse.u = static_cast<float>(fit.position[k]);
        pulse.amplitude = static_cast<float>(fit.amplitude[k]);
        pulse.width = static_cast<float>(fit.width);
        pulse.background = static_cast<float>(fit.background);
        pulse.chi_square = static_cast<float>(fit.chi_square);
        if (any_saturated) pulse.flags |= kPulseSaturated;
        if (fit.peaks > 1 || fit.unresolved) pulse.flags |= kPulseOverlapping;
        if (fit.width_at_limit) pulse.flags |= kPulseWidthOutOfRange;
        if (fit.position[k] - 2 * fit.width < -0.5 ||
            fit.position[k] + 2 * fit.width > width_ - 0.5)
            pulse.flags |= kPulseImageBorder;
        peaks.push_back(pulse);
        places_.push_back(place_peak(options_.method, values_, noise_, full_scale_, fit, k));
    }
}

/// Moves the row's peaks to where the method puts them; one for which it has no answer is dropped.
/// After all have been found, so that every method sees the same ones.
void RowPeakFinder::move_to_places(std::vector<Pulse>& peaks, std::size_t first) const {
    std::size_t kept = first;
    for (std::size_t i = 0; i < places_.size(); ++i) {
        if (!places_[i]) continue;
        peaks[kept] = peaks[first + i];
        peaks[kept].u = static_cast<float>(places_[i]->position);
        peaks[kept].sigma = static_cast<float>(places_[i]->sigma);
        ++kept;
    }
    peaks.resize(kept);
}

template void RowPeakFinder::find(const std::uint8_t*, std::vector<Pulse>&);
template void RowPeakFinder::find(const std::uint16_t*, std::vector<Pulse>&);

}  // namespace stria

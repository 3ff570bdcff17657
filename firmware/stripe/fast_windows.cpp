#include "firmware/stripe/fast_windows.h"

#include <algorithm>
#include <cmath>

#include "firmware/stripe/gaussian_fit.h"

namespace stria::fast {
namespace {

constexpr int kMaxLast = 256;  // of Closed::last

// The kernel judges what is clearly on one side of a limit of the reference's; shares of the
// limits.
constexpr float kNarrowest = 0.55f;  // frame periods; the kernel's aperture is exact enough above
constexpr int kLongEnough = 16;      // samples of a window whose misfit can be called noise
// Heights in two standard deviations of the background: weaker pulses can be fitted in several
// ways.
constexpr float kStrong = 4.0f, kVeryStrong = 10.0f;
constexpr float kClearlyAbove = 1.03f, kClearlyBelow = 0.97f;

TimeNs rounded(double ns) { return static_cast<TimeNs>(ns + (ns < 0 ? -0.5 : 0.5)); }

enum class Verdict { pulse, ask_reference };

/// What judging a window needs beyond its fit.
struct Limits {
    float smallest;     ///< DN, of the height
    float noticeable;   ///< chi-square per degree of freedom that one in thirty exceeds
    float significant;  ///< chi-square per degree of freedom
    float max_misfit;   ///< rms residual over amplitude
    float max_width;    ///< frame periods
    float first, last;  ///< times of the outermost samples
    int degrees;        ///< of freedom
};

float chi_square_of(const FitTask& fit, int lane, const Limits& limits) {
    return fit.chi_square[lane] / static_cast<float>(limits.degrees);
}

/// The greatest residual, smoothed over three samples: where the reference would look for a second
/// pulse.
float greatest_residual(const FitTask& fit, int lane) {
    const double exposed = std::sqrt(double{fit.width[lane]} * fit.width[lane] +
                                     fit.half_aperture * fit.half_aperture / 3.0);
    double before = 0, last = 0, greatest = 0;
    for (int i = 0; i < fit.length; ++i) {
        const double z = (double{fit.x[i]} - fit.position[lane]) / exposed;
        const double r = fit.y[i * kLanes + lane] - double{fit.level[lane]} -
                         fit.height[lane] * std::exp(-0.5 * z * z);
        if (i > 1) greatest = std::max(greatest, 0.25 * (before + 2.0 * last + r));
        before = last;
        last = r;
    }
    return static_cast<float>(greatest);
}

/// No more misfit than the reference takes for noise without a second look.
bool is_quiet(const FitTask& fit, int lane, const Limits& limits) {
    return chi_square_of(fit, lane, limits) < 0.998f * limits.significant;
}

/// True if the reference's fit, too, would leave it at a single pulse: the misfit is what noise
/// makes of one in some hundred strong pulses, and nothing is left over that may be another.
bool is_single(const FitTask& fit, int lane, const Limits& limits) {
    const float chi_square = chi_square_of(fit, lane, limits);
    if (chi_square < limits.noticeable) return true;
    const bool significant = chi_square > 1.002f * limits.significant;
    if (significant &&
        (chi_square > 1.5f * limits.significant ||
         fit.height[lane] < kVeryStrong * fit.least[lane] || fit.length < kLongEnough))
        return false;
    if (!significant && !is_quiet(fit, lane, limits)) return false;
    return greatest_residual(fit, lane) < 0.45f * limits.smallest;
}

/// A weak pulse over black, where the noise's slope has a bend: a likely place for two solutions.
bool is_dark(const FitTask& fit, int lane) {
    return fit.level[lane] - fit.black < 0.5f * fit.least[lane] &&
           fit.height[lane] < kVeryStrong * fit.least[lane];
}

/// Sure of a pulse, never of none: the reference may find a narrow one between the samples.
Verdict judge(const FitTask& fit, int lane, const Limits& limits) {
    const float width = fit.width[lane], height = fit.height[lane];
    const float position = fit.position[lane];
    const bool clipped = fit.peak[lane] + fit.background[lane] >= 255.0f;
    const bool inside = position > limits.first + 1.0f && position < limits.last - 1.0f;
    if (clipped || fit.converged[lane] == 0 || !inside || !(width < 0.3f * limits.max_width) ||
        !(width > kNarrowest) || !(height > 0))
        return Verdict::ask_reference;
    if (height < kStrong * fit.least[lane] || is_dark(fit, lane) || !is_single(fit, lane, limits))
        return Verdict::ask_reference;
    const float rms = std::sqrt(fit.squares[lane] / static_cast<float>(fit.length));
    const bool certain = height > kClearlyAbove * limits.smallest &&
                         fit.sigma[lane] < 0.8f * width && height > 4.0f * fit.height_sigma[lane] &&
                         rms < kClearlyBelow * limits.max_misfit * fit.amplitude[lane];
    return certain ? Verdict::pulse : Verdict::ask_reference;
}

}  // namespace

WindowBins::WindowBins(const FitSetting& setting, int begin, int end, std::vector<RowFinds>& rows)
    : setting_(setting),
      first_(begin),
      rows_(rows),
      first_frame_(setting.frames.first()),
      width_(static_cast<std::size_t>(setting.frames.at(begin).width)),
      by_frame_and_last_(static_cast<std::size_t>(end - begin) * kMaxLast) {
    for (int k = first_frame_; k < setting.frames.count(); ++k)
        frames_.push_back(setting.frames.at(k).bytes.data());
}

WindowBins::Bin& WindowBins::bin_of(int last_frame, int last) {
    Bin*& bin =
        by_frame_and_last_[static_cast<std::size_t>((last_frame - first_) * kMaxLast + last)];
    if (bin == nullptr) {
        bins_.push_back(std::make_unique<Bin>());
        bin = bins_.back().get();
        const WindowLimits limits = {setting_.options.max_pulse_frames,
                                     setting_.options.history_frames};
        bin->length = last + 1 + 2 * margin_frames(last, limits);
        bin->begin = last_frame + 1 - bin->length;
        bin->samples.resize(static_cast<std::size_t>(bin->length) * kLanes);
    }
    return *bin;
}

void WindowBins::take(int y, int last_frame, const Closed& closed) {
    Bin& bin = bin_of(last_frame, closed.last);
    PixelWindow window;
    window.x = closed.x;
    window.y = y;
    window.begin = std::max(bin.begin, 0);
    window.end = last_frame + 1;
    window.background = static_cast<float>(closed.background) / 256.0f;
    window.level = static_cast<float>(closed.threshold) + 1.0f;
    if (bin.begin <= 0) {  // the light rose before the sweep began, or nearly
        take_plainly(window);
        return;
    }
    const std::size_t at =
        static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(closed.x);
    const std::uint8_t* const* frame = frames_.data() + (bin.begin - first_frame_);
    std::uint8_t* sample = bin.samples.data() + bin.count;
    for (int i = 0; i < bin.length; ++i, sample += kLanes) *sample = frame[i][at];
    bin.windows[static_cast<std::size_t>(bin.count)] = window;
    if (++bin.count == kLanes) fit(bin);
}

void WindowBins::prefetch(int y, int begin, const std::vector<Closed>& windows) const {
    const WindowLimits limits = {setting_.options.max_pulse_frames,
                                 setting_.options.history_frames};
    std::int32_t last_line = -1;
    int last_at = -1;
    for (const Closed& window : windows) {
        const std::int32_t line = window.x / 64;
        if (line == last_line && window.at == last_at) continue;
        last_line = line;
        last_at = window.at;
        const std::size_t at =
            static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(window.x);
        const int end = begin + window.at + 1 - first_frame_;
        const int length = window.last + 1 + 2 * margin_frames(window.last, limits);
        for (int k = std::max(end - length, 0); k < end; ++k)
            __builtin_prefetch(frames_[static_cast<std::size_t>(k)] + at);
    }
}

void WindowBins::take_plainly(const PixelWindow& window) {
    RowFinds& row = rows_[static_cast<std::size_t>(window.y)];
    ++row.windows.all;
    ++row.windows.by_reference;
    const PulseLevels levels = pulse_levels(setting_.noise, setting_.options, window.background);
    note_effective_samples(effective_samples(setting_.frames, window, levels), row.effective);
    fit_window(setting_.frames, window, setting_.noise, setting_.options, row.pulses);
}

void WindowBins::flush() {
    for (const auto& bin : bins_)
        if (bin->count > 0) fit(*bin);
}

/// Fills lanes without a window with copies of the last one.
void WindowBins::fill(Bin& bin) {
    const auto last = static_cast<std::size_t>(bin.count - 1);
    for (std::size_t lane = last + 1; lane < kLanes; ++lane) {
        bin.windows[lane] = bin.windows[last];
        for (std::size_t i = 0; i < static_cast<std::size_t>(bin.length); ++i)
            bin.samples[i * kLanes + lane] = bin.samples[i * kLanes + last];
    }
}

void WindowBins::fit(Bin& bin) {
    fill(bin);
    const Frame& first = setting_.frames.at(bin.begin);
    const Frame& last = setting_.frames.at(bin.begin + bin.length - 1);
    const TimeNs middle = setting_.frames.at(bin.begin + bin.length / 2).row_time(0);
    const double period =
        static_cast<double>(last.row_time(0) - first.row_time(0)) / (bin.length - 1);
    std::array<float, kMaxFitSamples> times;
    for (int i = 0; i < bin.length; ++i)
        times[static_cast<std::size_t>(i)] = static_cast<float>(
            static_cast<double>(setting_.frames.at(bin.begin + i).row_time(0) - middle) / period);

    const SensorNoise& noise = setting_.noise;
    const double read = noise.read_noise_e / noise.gain_e_per_dn;
    FitTask task;
    task.length = bin.length;
    task.x = times.data();
    task.y = bin.samples.data();
    task.half_aperture = static_cast<float>(0.5 * static_cast<double>(first.exposure_ns) / period);
    task.variance_floor = static_cast<float>(read * read + 1.0 / 12.0);
    task.variance_gain = static_cast<float>(1.0 / noise.gain_e_per_dn);
    task.black = static_cast<float>(noise.black_dn);
    task.min_width = static_cast<float>(std::sqrt(
        kMinPulseWidth * kMinPulseWidth + double{task.half_aperture} * task.half_aperture / 3.0));
    task.max_width = 0.5f * static_cast<float>(setting_.options.max_pulse_frames);
    std::array<PulseLevels, kLanes> levels;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        task.background[lane] = bin.windows[lane].background;
        levels[lane] = pulse_levels(noise, setting_.options, task.background[lane]);
        task.least[lane] = levels[lane].least;
    }
    fit_windows(task);
    for (int lane = 0; lane < bin.count; ++lane)
        settle(bin.windows[static_cast<std::size_t>(lane)], levels[static_cast<std::size_t>(lane)],
               task, lane, middle, period);
    bin.count = 0;
}

void WindowBins::settle(const PixelWindow& window, const PulseLevels& levels, const FitTask& task,
                        int lane, TimeNs middle, double period) {
    const SpacetimeOptions& options = setting_.options;
    RowFinds& row = rows_[static_cast<std::size_t>(window.y)];
    ++row.windows.all;
    if (task.peak[lane] >= 2.0f * (window.level - window.background))
        note_effective_samples(task.effective[lane], row.effective);

    if (task.pair[lane] < levels.pair) return;
    Limits limits;
    limits.smallest = levels.smallest;
    limits.degrees = std::max(task.length - 4, 1);
    const float spread = std::sqrt(2.0f / static_cast<float>(limits.degrees));
    limits.noticeable = 1.0f + 2.0f * spread;
    limits.significant = 1.0f + 3.0f * spread;
    limits.max_misfit = static_cast<float>(options.max_misfit);
    limits.max_width = 2.0f * task.max_width;
    limits.first = task.x[0];
    limits.last = task.x[task.length - 1];
    const Verdict verdict = judge(task, lane, limits);
    if (verdict == Verdict::ask_reference) {
        ++row.windows.by_reference;
        fit_window(setting_.frames, window, setting_.noise, options, row.pulses);
        return;
    }
    if (row.pulses.empty()) row.pulses.reserve(width_);
    const Frame& first = setting_.frames.at(window.begin);
    Pulse pulse;
    pulse.u = static_cast<float>(window.x);
    pulse.v = static_cast<float>(window.y);
    pulse.t_ns = middle + window.y * first.row_time_ns +
                 rounded(static_cast<double>(task.position[lane]) * period);
    pulse.amplitude = task.amplitude[lane];
    pulse.width = static_cast<float>(task.width[lane] * period);
    pulse.background = task.level[lane];
    pulse.chi_square = chi_square_of(task, lane, limits);
    const float inflation =
        pulse.chi_square > limits.significant ? std::sqrt(pulse.chi_square) : 1.0f;
    pulse.sigma = static_cast<float>(task.sigma[lane] * inflation * period);
    pulse.laser_id = first.laser_id;
    pulse.exposure_index = first.exposure_index;
    row.pulses.push_back(pulse);
}

}  // namespace stria::fast

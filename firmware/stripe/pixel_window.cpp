#include "firmware/stripe/pixel_window.h"

#include <algorithm>
#include <cmath>

#include "firmware/stripe/gaussian_fit.h"

namespace stria {
namespace {

constexpr double kFwhmPerSigma = 2.3548;

/// The window's samples over time in units of its mean frame period, from its first frame on.
struct TimedSamples {
    FitSamples samples;
    TimeNs reference_ns = 0;
    double period_ns = 1;
    bool any_saturated = false;
};

TimedSamples gather(const FrameStore& frames, const PixelWindow& window) {
    TimedSamples out;
    const Frame& first = frames.at(window.begin);
    const Frame& last = frames.at(window.end - 1);
    out.samples.count = std::min(window.end - window.begin, kMaxFitSamples);
    out.reference_ns = first.row_time(window.y);
    if (out.samples.count > 1)
        out.period_ns = static_cast<double>(last.row_time(window.y) - out.reference_ns) /
                        (window.end - window.begin - 1);
    out.samples.half_aperture = 0.5 * static_cast<double>(first.exposure_ns) / out.period_ns;
    for (int i = 0; i < out.samples.count; ++i) {
        const Frame& frame = frames.at(window.begin + i);
        const int value = frame.sample(window.x, window.y);
        out.samples.x[i] =
            static_cast<double>(frame.row_time(window.y) - out.reference_ns) / out.period_ns;
        out.samples.y[i] = value;
        out.samples.saturated[i] = value >= frame.full_scale();
        out.any_saturated |= out.samples.saturated[i] != 0;
    }
    return out;
}

/// Start values: the highest sample, and the width at half its height.
FitStart start_of(const FitSamples& samples, double background, int max_pulse_frames) {
    int top = 0;
    for (int i = 1; i < samples.count; ++i)
        if (samples.y[i] > samples.y[top]) top = i;
    const double half = 0.5 * (samples.y[top] + background);
    int low = top, high = top;
    while (low > 0 && samples.y[low - 1] > half) --low;
    while (high < samples.count - 1 && samples.y[high + 1] > half) ++high;
    FitStart start;
    start.min_width = kMinPulseWidth;
    start.max_width = 0.5 * max_pulse_frames;
    start.width = std::clamp((high - low + 1) / kFwhmPerSigma, 0.5, start.max_width);
    start.position = 0.5 * (samples.x[low] + samples.x[high]);
    start.background = background;
    start.widths_may_differ = true;
    start.amplitude = samples.y[top] - background;
    start.search = true;
    return start;
}

/// The greatest sum of two successive samples, above the tracked background.
float greatest_pair(const FitSamples& samples, float background) {
    float greatest = 0, last = 0;
    for (int i = 0; i < samples.count; ++i) {
        const float a = static_cast<float>(samples.y[i]) - background;
        if (i > 0) greatest = std::max(greatest, last + a);
        last = a;
    }
    return greatest;
}

}  // namespace

PulseLevels pulse_levels(const SensorNoise& noise, const SpacetimeOptions& options,
                         float background) {
    const double noise_dn = std::sqrt(sample_variance(noise, background));
    const double smallest = std::max(options.min_amplitude_dn, options.min_snr * noise_dn);
    return {static_cast<float>(2.0 * noise_dn), static_cast<float>(smallest),
            static_cast<float>(1.05 * smallest)};
}

float effective_samples(const FrameStore& frames, const PixelWindow& window,
                        const PulseLevels& levels) {
    const float least = levels.least;
    float sum = 0, squares = 0, peak = 0;
    for (int k = window.begin; k < window.end; ++k) {
        const float a =
            static_cast<float>(frames.at(k).sample(window.x, window.y)) - window.background;
        if (a < least) continue;
        sum += a;
        squares += a * a;
        peak = std::max(peak, a);
    }
    return peak < 2.0f * (window.level - window.background) ? 0.0f : sum * sum / squares;
}

void note_effective_samples(float samples, SampleHistogram& histogram) {
    if (samples <= 0.0f) return;
    // No light above the noise gives NaN: the last bin, on every processor.
    const float bin = (samples - 1.0f) * 20.0f + 0.5f;
    const std::size_t last = histogram.size() - 1;
    ++histogram[bin < static_cast<float>(last) ? static_cast<std::size_t>(bin) : last];
}

void fit_window(const FrameStore& frames, const PixelWindow& window, const SensorNoise& noise,
                const SpacetimeOptions& options, std::vector<Pulse>& pulses) {
    if (window.end - window.begin < 5) return;
    const Frame& first = frames.at(window.begin);
    const TimedSamples timed = gather(frames, window);
    const FitSamples& samples = timed.samples;
    const PulseLevels levels = pulse_levels(noise, options, window.background);
    if (greatest_pair(samples, window.background) < levels.pair) return;
    const double smallest = levels.smallest;
    const FitStart start = start_of(samples, window.background, options.max_pulse_frames);
    const GaussianFit fit = fit_pulses(samples, noise, first.full_scale(), start, smallest);
    if (!fit.converged || fit.rms_residual > options.max_misfit * fit.amplitude[0]) return;

    for (int k = 0; k < fit.peaks; ++k) {
        if (sampled_amplitude(fit, k, samples.half_aperture) < smallest) continue;
        Pulse pulse;
        pulse.u = static_cast<float>(window.x);
        pulse.v = static_cast<float>(window.y);
        pulse.t_ns = timed.reference_ns +
                     static_cast<TimeNs>(std::llround(fit.position[k] * timed.period_ns));
        pulse.amplitude = static_cast<float>(fit.amplitude[k]);
        pulse.width = static_cast<float>(fit.width_of(k) * timed.period_ns);
        pulse.background = static_cast<float>(fit.background);
        pulse.sigma = static_cast<float>(fit.sigma[k] * sigma_inflation(fit) * timed.period_ns);
        pulse.chi_square = static_cast<float>(fit.chi_square);
        pulse.laser_id = first.laser_id;
        pulse.exposure_index = first.exposure_index;
        if (timed.any_saturated) pulse.flags |= kPulseSaturated;
        if (fit.peaks > 1 || fit.unresolved) pulse.flags |= kPulseOverlapping;
        if (fit.width_at_limit) pulse.flags |= kPulseWidthOutOfRange;
        const bool cut_before =
            window.begin == 0 && fit.position[k] - 2 * fit.width_of(k) < samples.x[0];
        const bool cut_after = window.at_sequence_end &&
                               fit.position[k] + 2 * fit.width_of(k) > samples.x[samples.count - 1];
        if (cut_before || cut_after) pulse.flags |= kPulseTouchesSequenceEnd;
        pulses.push_back(pulse);
    }
}

}  // namespace stria

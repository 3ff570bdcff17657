// Which pulses a window holds: one or two, or none; see fit_pulses() in gaussian_fit.h.
#include <algorithm>
#include <cmath>

#include "firmware/stripe/fit_search.h"
#include "firmware/stripe/gaussian_fit.h"

namespace stria {
namespace {

// Equal Gaussians nearer than so many widths have one maximum together: a light that a tilted
// surface broadened looks the same.
constexpr double kTwoMaxima = 2.0;
// A sharp and a broader pulse are two from so many of the sharp one's widths on, and one of the
// broader one's.
constexpr double kStandsApart = 1.5;

/// Sample i over the single pulse, the aperture's blur to second order.
double residual_at(const FitSamples& samples, const GaussianFit& fit, int i) {
    const double h = samples.half_aperture, w = fit.width;
    const double d = samples.x[i] - fit.position[0];
    const double g = std::exp(-0.5 * d * d / (w * w + h * h / 3.0));
    const double blur = w / std::sqrt(w * w + h * h / 3.0);
    return samples.y[i] - fit.background - fit.amplitude[0] * blur * g;
}

/// Where a second pulse would help most: the greatest residual, smoothed over three samples.
struct Residual {
    double position = 0, amplitude = 0;
};

Residual greatest_residual(const FitSamples& samples, const GaussianFit& fit) {
    Residual best;
    for (int i = 1; i + 1 < samples.count; ++i) {
        const double r = (residual_at(samples, fit, i - 1) + 2.0 * residual_at(samples, fit, i) +
                          residual_at(samples, fit, i + 1)) /
                         4.0;
        if (r > best.amplitude) best = {samples.x[i], r};
    }
    return best;
}

/// True if the samples about the pulse's middle lie below it, as of two alike seen as one.
bool is_flat_topped(const FitSamples& samples, const GaussianFit& fit) {
    double sum = 0;
    for (int i = 0; i < samples.count; ++i)
        if (std::abs(samples.x[i] - fit.position[0]) < 0.7 * fit.width)
            sum += residual_at(samples, fit, i);
    return sum < 0;
}

bool significant_misfit(const GaussianFit& fit) {
    return fit.chi_square > 1.0 + 3.0 * std::sqrt(2.0 / fit.degrees_of_freedom);
}

/// Every pulse lies inside the window, known to about its own width, and is there at all.
bool is_certain(const FitSamples& samples, const GaussianFit& fit) {
    const double half_step = 0.5 * (samples.x[1] - samples.x[0]);
    const double first = samples.x[0], last = samples.x[samples.count - 1];
    const bool clipped =
        std::count(samples.saturated.begin(), samples.saturated.begin() + samples.count, 1) > 0;
    for (int k = 0; k < fit.peaks; ++k) {
        if (fit.sigma[k] > fit.width_of(k) + half_step) return false;
        // A narrow or clipped pulse may trade height against width and yet be certain.
        if (!clipped && fit.width_of(k) > 3.0 * half_step &&
            fit.amplitude[k] < 3.0 * fit.sigma_amplitude[k])
            return false;
        if (fit.position[k] <= first - half_step || fit.position[k] >= last + half_step)
            return false;
    }
    return true;
}

/// True if some sample between the two pulses lies clearly below the lower one's height.
bool has_valley(const FitSamples& samples, const GaussianFit& two) {
    const double low = std::min(two.position[0], two.position[1]);
    const double high = std::max(two.position[0], two.position[1]);
    double top_low = 0, top_high = 0, valley = 1e300;
    for (int i = 0; i < samples.count; ++i) {
        const double x = samples.x[i], y = samples.y[i];
        if (std::abs(x - low) < two.width) top_low = std::max(top_low, y);
        if (std::abs(x - high) < two.width) top_high = std::max(top_high, y);
        if (x > low && x < high) valley = std::min(valley, y);
    }
    const double lower_top = std::min(top_low, top_high);
    return valley - two.background < 0.8 * (lower_top - two.background);
}

/// Started at the single pulse and what it leaves over: a strong pulse and a weak one. Where that
/// does not explain the samples, also at its two flanks: two alike, whose single fit is a wide one
/// in the middle.
GaussianFit best_two(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                     const GaussianFit& one, const Residual& residual, const FitStart& limits) {
    GaussianFit from = one;
    from.position[1] = residual.position;
    from.amplitude[1] = residual.amplitude;
    const GaussianFit unequal = fit_two_gaussians(samples, noise, full_scale, from, limits);
    if (unequal.converged && !significant_misfit(unequal)) return unequal;
    if (!is_flat_topped(samples, one)) return unequal;

    from.width = 0.6 * one.width;
    from.position = {one.position[0] - 0.8 * one.width, one.position[0] + 0.8 * one.width};
    from.amplitude = {one.amplitude[0], one.amplitude[0]};
    const GaussianFit alike = fit_two_gaussians(samples, noise, full_scale, from, limits);
    if (!unequal.converged) return alike;
    return alike.converged && alike.deviance < unequal.deviance ? alike : unequal;
}

/// The single pulse from `start`; where that leaves a doubt (no certain pulse, a significant
/// misfit, a width at its limit), the more likely one of it and of what a search begins with.
GaussianFit best_one(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                     const FitStart& start) {
    GaussianFit one = fit_one_gaussian(samples, noise, full_scale, start);
    one.converged = one.converged && is_certain(samples, one);
    if (!start.search || (one.converged && !one.width_at_limit && !significant_misfit(one)))
        return one;
    const auto searched = search_start(samples, noise, full_scale, start);
    if (!searched) return one;
    const GaussianFit other = fit_one_gaussian(samples, noise, full_scale, *searched);
    if (!other.converged || !is_certain(samples, other)) return one;
    return !one.converged || other.deviance < one.deviance ? other : one;
}

/// Whether a sharp pulse and a weaker, broader one explain the samples where `otherwise` does not,
/// and stand apart. (A pulse on its own pedestal does not; and the flat top of a tilted surface's
/// light is described by a broad pulse and a weaker, sharper one.)
bool are_unlike(const FitSamples& samples, const GaussianFit& two, const GaussianFit& otherwise,
                double min_amplitude) {
    if (!two.converged || two.width_at_limit || !is_certain(samples, two)) return false;
    if (two.second_width < two.width) return false;
    const double separation = std::abs(two.position[0] - two.position[1]);
    if (separation < std::max(kStandsApart * two.width, two.second_width)) return false;
    if (two.amplitude[1] < std::max(min_amplitude, 0.05 * two.amplitude[0])) return false;
    const double parameters = otherwise.peaks == 1 ? 3.0 : 1.0;
    const double penalty = parameters * std::log(static_cast<double>(samples.count));
    return (otherwise.deviance - two.deviance) / std::max(two.chi_square, 1.0) > penalty;
}

/// One pulse or two of a common width.
GaussianFit fit_alike(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                      const FitStart& start, double min_amplitude) {
    GaussianFit one = best_one(samples, noise, full_scale, start);
    if (!one.converged || !significant_misfit(one)) return one;
    const Residual residual = greatest_residual(samples, one);
    if (residual.amplitude < 0.5 * min_amplitude) return one;

    const GaussianFit two = best_two(samples, noise, full_scale, one, residual, start);
    if (!two.converged || two.width_at_limit || !is_certain(samples, two)) return one;
    const double separation = std::abs(two.position[0] - two.position[1]);
    const double smallest = std::max(min_amplitude, 0.05 * two.amplitude[0]);
    if (separation < two.width || two.amplitude[1] < smallest) return one;
    // A flat-topped profile is also better described by two Gaussians: where even those do not
    // explain the samples, two pulses need a valley between them.
    if (significant_misfit(two) && !has_valley(samples, two)) return one;
    const double scale = std::max(two.chi_square, 1.0);
    const double penalty = 2.0 * std::log(static_cast<double>(samples.count));  // 2 parameters
    if ((one.deviance - two.deviance) / scale <= penalty) return one;
    if (separation >= kTwoMaxima * two.width) return two;
    one.unresolved = true;
    return one;
}

}  // namespace

GaussianFit fit_pulses(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                       const FitStart& start, double min_amplitude) {
    const GaussianFit alike = fit_alike(samples, noise, full_scale, start, min_amplitude);
    if (!start.widths_may_differ || !alike.converged || !significant_misfit(alike)) return alike;
    GaussianFit from = alike;
    if (alike.peaks == 1) {
        const Residual residual = greatest_residual(samples, alike);
        if (residual.amplitude < 0.5 * min_amplitude) return alike;
        from.position[1] = residual.position;
        from.amplitude[1] = residual.amplitude;
    }
    const GaussianFit unlike = fit_unlike_gaussians(samples, noise, full_scale, from, start);
    return are_unlike(samples, unlike, alike, min_amplitude) ? unlike : alike;
}

double sampled_amplitude(const GaussianFit& fit, int k, double half_aperture) {
    const double w = fit.width_of(k), w2 = w * w;  // a box of half length h adds h^2 / 3
    return fit.amplitude[k] * w / std::sqrt(w2 + half_aperture * half_aperture / 3.0);
}

double sigma_inflation(const GaussianFit& fit) {
    return significant_misfit(fit) ? std::sqrt(fit.chi_square) : 1.0;
}

}  // namespace stria

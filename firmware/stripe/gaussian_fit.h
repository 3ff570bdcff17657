#pragma once
#include <array>
#include <cstdint>

#include "firmware/core/sensor_noise.h"

namespace stria {

constexpr int kMaxFitSamples = 192;  ///< a window never holds more

/// The samples of a window: positions x (px, or frame periods), values y (DN). Each integrates the
/// light from x - half_aperture to x + half_aperture.
struct FitSamples {
    int count = 0;
    double half_aperture = 0.5;
    std::array<double, kMaxFitSamples> x;
    std::array<double, kMaxFitSamples> y;
    std::array<std::uint8_t, kMaxFitSamples> saturated;  ///< 1: y is full scale, truly more
    /// Samples interpolated between pixels: variance over that of one pixel, sum of the weights'
    /// squares. Read only where `interpolated`.
    std::array<double, kMaxFitSamples> variance_share;
    bool interpolated = false;
};

/// Where a fit starts, and between which widths it stays.
struct FitStart {
    double position = 0;
    double amplitude = 0;
    double width = 1;
    double background = 0;
    double min_width = 0.3;
    double max_width = 12;
    bool search = false;  ///< fit_pulses: where a fit leaves a doubt, also from search_start()
    bool widths_may_differ = false;  ///< fit_pulses: of two
};

/// One or two Gaussian pulses over a constant background.
struct GaussianFit {
    int peaks = 1;
    std::array<double, 2> position{};   ///< unit of x
    std::array<double, 2> amplitude{};  ///< DN at the centre, before the aperture blurs it
    std::array<double, 2> sigma{};      ///< standard deviation of position, from the Fisher matrix
    std::array<double, 2> sigma_amplitude{};
    double width = 0;         ///< Gaussian standard deviation, unit of x
    double second_width = 0;  ///< of the second pulse: the same unless fitted apart
    double background = 0;    ///< DN
    double chi_square = 0;    ///< per degree of freedom, unsaturated samples only
    int degrees_of_freedom = 0;
    double deviance = 0;      ///< -2 log likelihood, up to a constant of the samples
    double rms_residual = 0;  ///< DN, unsaturated samples
    bool converged = false;
    bool width_at_limit = false;
    bool unresolved = false;  ///< one pulse stands for what may be two: see fit_pulses
    int iterations = 0;

    double width_of(int k) const { return k == 0 ? width : second_width; }
};

/// Maximum-likelihood fit: model A sqrt(2 pi) w / (2 h) [Phi((x+h-m)/w) - Phi((x-h-m)/w)] + b,
/// noise as sample_variance() says at the model's value (Fisher scoring with Levenberg-Marquardt
/// damping); a saturated sample contributes the probability of exceeding full scale. Heights above
/// 8 full scales carry a weak prior (log-normal, a factor of e one standard deviation): the few
/// samples left of such a pulse do not tell height from width.
/// Needs more samples than parameters, else converged stays false.
GaussianFit fit_one_gaussian(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                             const FitStart& start);

/// Two pulses of a common width, started where `from` has its two; the stronger comes back first.
GaussianFit fit_two_gaussians(const FitSamples& samples, const SensorNoise& noise,
                              double full_scale, const GaussianFit& from, const FitStart& limits);

/// Two pulses of widths of their own, the better fit of two starts: either the broader one.
GaussianFit fit_unlike_gaussians(const FitSamples& samples, const SensorNoise& noise,
                                 double full_scale, const GaussianFit& from,
                                 const FitStart& limits);

/// Fits one pulse and, where that leaves a significant misfit, two; returns the two only if the
/// Bayesian information criterion prefers them (deviances scaled by the better fit's chi-square),
/// they stand at least two widths apart and the weaker has `min_amplitude` DN and 5 % of the other.
/// Nearer than that, but not than one width, the single pulse comes back marked `unresolved`.
/// With `widths_may_differ`, where that leaves a significant misfit, a sharp pulse and a weaker,
/// broader one are tried (what surfaces throw on each other lasts longer than the beam), and taken
/// where the criterion asks for them and they stand 1.5 widths of the sharp one apart and one of
/// the broad one.
/// A pulse at the end of the window, or whose sigma exceeds its width and half a sample, or whose
/// amplitude is below 3 of its sigmas though it is wide and not clipped (a slope of the background)
/// is none: converged is false then.
GaussianFit fit_pulses(const FitSamples& samples, const SensorNoise& noise, double full_scale,
                       const FitStart& start, double min_amplitude);

/// Height (DN) of pulse k as the samples show it, blurred by the aperture: what min_snr is about.
double sampled_amplitude(const GaussianFit& fit, int k, double half_aperture);

/// Factor >= 1 by which a fit's sigmas grow: sqrt(chi-square) if that exceeds 1 by more than three
/// of its standard deviations, sqrt(2 / degrees of freedom).
double sigma_inflation(const GaussianFit& fit);

}  // namespace stria

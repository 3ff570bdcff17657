#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/gaussian_fit.h"

namespace stria {

/// How the sub-pixel place of a stripe in an image row is computed. All of them place the same
/// peaks: where a stripe is, how wide it is and whether it is two, is decided by detection and by
/// the maximum-likelihood fit, which costs the same for every method.
///
/// w below is the stripe's width with the pixel's own blur, sqrt(width^2 + 1/12) px; windows lie
/// about the pixel nearest to the fit; the background is the mean of four samples on either side,
/// from 4 w on; of two peaks fitted together each is placed with the other's light removed.
/// RMS error over the Cramer-Rao bound and greatest noise-free bias are in the README's tables.
enum class PeakMethod : std::uint8_t {
    /// The fit itself: pixel-integrated Gaussian, noise of the sensor, saturation as such.
    maximum_likelihood = 0,
    /// Centre of gravity over +-3 w. Hardly biased, whatever the symmetric profile; 1.7 to 2.6
    /// times the bound, since the flanks weigh most and know least.
    centre_of_gravity,
    /// Parabola through the logarithms of the samples within 1.95 w (15 % of the height; at least
    /// three), weighted with their squares, which is what the logarithm does to their noise; just
    /// three samples are the Gaussian interpolation of Naidu & Fisher (1991). Saturated samples are
    /// left out, and the window grows to two good ones on either flank.
    log_parabola,
    /// Zero crossing of the sums of four samples on either side, linearly interpolated: Blais &
    /// Rioux (1986), order 8. For w near 1.5. The bias of the interpolation, up to 0.016 px,
    /// exceeds sigma for w <= 1 at SNR 200.
    blais_rioux,
    /// Greatest normalised correlation with the pixel-integrated Gaussian of the fitted width: zero
    /// crossing of the derivative filter (Forest, Salvi et al. 2004), taken to its end by Newton's
    /// method instead of linear interpolation, so that it has no bias.
    matched_fir,
    /// Steger (1998) in one dimension: second-order Taylor polynomial of the row smoothed with a
    /// Gaussian of w. One-dimensional on purpose: in two dimensions it would average along the
    /// stripe, and the sigmas of neighbouring rows, which everything after treats as independent,
    /// would not be. Its bias, offset^3 / (2 w^2) for an offset of up to half a pixel, exceeds
    /// sigma for w <= 1 from SNR 20 on, at 1.5 from 50, at 2.5 from 200.
    steger,
};

inline constexpr std::array kPeakMethods = {
    PeakMethod::maximum_likelihood, PeakMethod::centre_of_gravity, PeakMethod::log_parabola,
    PeakMethod::blais_rioux,        PeakMethod::matched_fir,       PeakMethod::steger};

/// As on the command line: ml, cog, log-parabola, blais-rioux, fir, steger.
std::string_view name_of(PeakMethod method);
/// Empty for a name that is none of those.
std::optional<PeakMethod> peak_method_from(std::string_view name);

/// Where a peak is along the row (px), and the standard deviation of that: the method's own
/// derivative by every sample, times that sample's noise. Bias is not in it.
struct PlacedPeak {
    double position = 0;
    double sigma = 0;
};

/// Place of peak k of the fit, from the row's samples (DN) alone. Empty where the method has no
/// answer: its window leaves the row, too few samples are left unsaturated, or what it looks for (a
/// zero crossing, a maximum) is not there.
std::optional<PlacedPeak> place_peak(PeakMethod method, std::span<const float> row,
                                     const SensorNoise& noise, double full_scale,
                                     const GaussianFit& fit, int k);

}  // namespace stria

#pragma once
#include <cmath>

namespace stria {

constexpr double kSqrtTwoPi = 2.5066282746310002;

/// exp(-z^2/2) and the normal distribution function at z.
struct NormalTerms {
    double density;  ///< exp(-z^2 / 2), not normalised
    double cumulative;
};

/// Abramowitz & Stegun 26.2.17: cumulative to 7.5e-8, which is 0.005 DN at 16 bits; one exponential
/// serves both numbers.
inline NormalTerms normal_terms(double z) {
    const double density = std::exp(-0.5 * z * z);
    const double t = 1.0 / (1.0 + 0.2316419 * std::abs(z));
    const double tail =
        density / kSqrtTwoPi * t *
        (0.319381530 +
         t * (-0.356563782 + t * (1.781477937 + t * (-1.821255978 + t * 1.330274429))));
    return {density, z > 0 ? 1.0 - tail : tail};
}

/// Mean of a unit-height Gaussian over an aperture, with its derivatives.
struct ApertureGaussian {
    double value;
    double by_position;
    double by_log_width;
};

/// Gaussian of width w centred at distance d = x - position, averaged over [d - h, d + h], from the
/// terms at both ends.
inline ApertureGaussian aperture_gaussian(const NormalTerms& low, const NormalTerms& high,
                                          double z_low, double z_high, double width, double h) {
    const double scale = 1.0 / (2.0 * h);
    const double integral = kSqrtTwoPi * width * (high.cumulative - low.cumulative);
    return {integral * scale, (low.density - high.density) * scale,
            (integral + width * (z_low * low.density - z_high * high.density)) * scale};
}

/// The same where h is small against the width: second order in h / w.
inline ApertureGaussian narrow_aperture_gaussian(double z, double width, double h) {
    const double q = h * h / (6.0 * width * width);
    const double g = std::exp(-0.5 * z * z);
    const double z2 = z * z;
    const double factor = 1.0 + q * (z2 - 1.0);
    return {g * factor, g * z / width * (factor - 2.0 * q),
            g * (z2 * factor - 2.0 * q * (z2 - 1.0) - 2.0 * q * z2)};
}

}  // namespace stria

#include "host/advise/gaussian_beam.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace stria {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

double rayleigh_mm(const GaussianBeam& beam) {
    return 4 * std::numbers::pi * beam.waist_sigma_mm * beam.waist_sigma_mm /
           (beam.m_squared * beam.wavelength_nm * 1e-6);
}

double sigma_at_mm(const GaussianBeam& beam, double from_waist_mm) {
    return beam.waist_sigma_mm * std::hypot(1.0, from_waist_mm / rayleigh_mm(beam));
}

double wavefront_radius_mm(const GaussianBeam& beam, double from_waist_mm) {
    if (from_waist_mm == 0) return kInfinite;
    const double ratio = rayleigh_mm(beam) / from_waist_mm;
    return from_waist_mm * (1 + ratio * ratio);
}

double depth_of_field_mm(const GaussianBeam& beam) { return 2 * rayleigh_mm(beam); }

double waist_for_mm(double sigma_mm, double from_waist_mm, double wavelength_nm, double m_squared) {
    // sigma^2 = x + k^2 / x with x = sigma0^2.
    const double k =
        m_squared * wavelength_nm * 1e-6 * std::abs(from_waist_mm) / (4 * std::numbers::pi);
    const double half = sigma_mm * sigma_mm / 2;
    if (half <= k) return std::sqrt(k);
    if (k == 0) return sigma_mm;
    return std::sqrt(k * k / (half + std::sqrt(half * half - k * k)));
}

double effective_distance_mm(double turning_mm, double wavefront_mm) {
    const double tilt = std::abs(1 / turning_mm - 1 / wavefront_mm);
    return tilt > 0 ? 1 / tilt : kInfinite;
}

}  // namespace stria

#include "host/advise/speckle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stria {
namespace {

constexpr int kNodes = 64;  // a side: the integral's error stays below 1e-4 up to 8 rho

/// |mu|^2 of a circular aperture at r / rho.
double coherence(double r) {
    const double x = std::numbers::pi * r;
    if (x < 1e-6) return 1;
    const double airy = 2 * std::cyl_bessel_j(1.0, x) / x;
    return airy * airy;
}

}  // namespace

double speckle_size_mm(double wavelength_nm, double sin_u) {
    return wavelength_nm * 1e-6 / (2 * sin_u);
}

double contrast_after_pixel(double contrast, double pixel_mm, double rho_mm) {
    const double side = pixel_mm / rho_mm;
    double inverse_cells = 0;
    for (int i = 0; i < kNodes; ++i)
        for (int k = 0; k < kNodes; ++k) {
            const double x = (i + 0.5) / kNodes, y = (k + 0.5) / kNodes;
            inverse_cells += (1 - x) * (1 - y) * coherence(side * std::hypot(x, y));
        }
    return contrast * std::sqrt(4 * inverse_cells / (kNodes * kNodes));
}

double dorsch_mm(double contrast, double wavelength_nm, double sin_u) {
    return contrast * wavelength_nm * 1e-6 / (2 * std::numbers::pi * sin_u);
}

double spatial_speckle_mm(double contrast, double rho_mm, double sigma_b_mm) {
    return std::max(contrast * rho_mm / std::numbers::pi,
                    0.376 * contrast * std::sqrt(rho_mm * sigma_b_mm));
}

double boiling_speckle_mm(double contrast, double sigma_b_mm, double effective_distance_mm,
                          double sin_u) {
    return 1.2 * contrast * sigma_b_mm * sigma_b_mm / (effective_distance_mm * sin_u);
}

double temporal_speckle_mm(double contrast, double wavelength_nm, double sin_u, double sigma_b_mm,
                           double effective_distance_mm) {
    return std::hypot(dorsch_mm(contrast, wavelength_nm, sin_u),
                      boiling_speckle_mm(contrast, sigma_b_mm, effective_distance_mm, sin_u));
}

}  // namespace stria

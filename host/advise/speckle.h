#pragma once

/// What speckle costs on a rough surface (accuracy.md A.4, findings 3 to 5). Lengths in mm on the
/// object, transverse to the camera's line of sight.
namespace stria {

/// Size of a speckle on the object, rho = lambda / (2 sin u).
double speckle_size_mm(double wavelength_nm, double sin_u);

/// Contrast that is left after a square pixel has averaged over it:
/// 1 / M = integral of the pixel's autocorrelation times |2 J1(pi r / rho) / (pi r / rho)|^2, for
/// a circular aperture; C = contrast / sqrt(M). Source: Goodman, Statistical properties of laser
/// speckle patterns, 1975, integrated speckle.
/// @param contrast  before the pixel: 1 for polarised light, 0.71 from a surface that depolarises
double contrast_after_pixel(double contrast, double pixel_mm, double rho_mm);

/// C lambda / (2 pi sin u) = C rho / pi: what no analysis of a frozen speckle beats.
/// Source: Dorsch, Hausler, Herrmann 1994.
double dorsch_mm(double contrast, double wavelength_nm, double sin_u);

/// Centre of gravity of a stripe of width sigma_b across its image: 0.376 C sqrt(rho sigma_b), not
/// below Dorsch's limit, to which it tends at sigma_b = rho / 2. accuracy.md finding 3.
double spatial_speckle_mm(double contrast, double rho_mm, double sigma_b_mm);

/// What a pulse over time adds because the light's direction turns while the beam crosses:
/// 1.2 C sigma_b^2 / (D_eff sin u), accuracy.md finding 4; its coefficient scattered by a third.
double boiling_speckle_mm(double contrast, double sigma_b_mm, double effective_distance_mm,
                          double sin_u);

/// A pulse over time: Dorsch's limit of the frozen speckle and what boils, in quadrature.
double temporal_speckle_mm(double contrast, double wavelength_nm, double sin_u, double sigma_b_mm,
                           double effective_distance_mm);

}  // namespace stria

#pragma once
#include <cstdint>
#include <vector>

#include "sim/coherent_speckle.h"

namespace stria {

/// Root mean squares of errors across the stripe, mm on the surface; weighted: each by its light.
struct SpeckleError {
    double weighted_mm = 0, unweighted_mm = 0;
};

/// What speckle does to one way of scanning.
struct SpeckleResult {
    double rho_mm = 0;
    double contrast = 0;     ///< of pixels in even light
    double dorsch_mm = 0;    ///< contrast lambda / (2 pi sin u)
    int pixels = 0;          ///< that the line passed
    double claimed = 0;      ///< share of them in which spacetime analysis found a pulse
    SpeckleError spacetime;  ///< stria's SpacetimeAnalyser, maximum likelihood, claimed pulses
    SpeckleError centred;    ///< the same, at the pulses' centres of light by kFootprintRhos
    std::vector<double> footprint_rhos;  ///< that the pulses show, of each surface that shows one
    SpeckleError moments;  ///< first moment over time, 6 sigma to both sides of the pixel
    double moments_by_square_mm = 0;  ///< the same, each weighted by its light's square
    SpeckleError spatial;             ///< first moment over a row of pixels, 5 sigma to both sides
};

struct SpeckleTrials {
    CoherentView view;
    CoherentLine line;
    int surfaces = 4;
    double step_sigmas = 0.4;  ///< of the line between frames
    std::uint64_t seed = 1;
};

/// The footprint with which pulses are moved to their centre of light, over rho: a pixel of 1.5 rho
/// and the kernel of a circular aperture together, as `estimate_footprint` finds it on the
/// cross-section model at sigma_b of 2 to 8 rho.
constexpr double kFootprintRhos = 0.54;

/// Lets the line cross surfaces in steps, noise-free frames, and finds it again by pixel over time
/// and by row in space. The camera does not move. view.columns is set to what the line needs.
SpeckleResult run(SpeckleTrials trials);

/// What moments_by_square_mm is for a point of the image, a sharp aperture and frozen speckle, in
/// rho, by quadrature. With G(x) the light's amplitude at the point from the line x of the surface
/// and A(u) = exp(-u^2 / (8 sigma^2)) (the overlap of the beam with itself), a pulse's light is
/// W = sum G G'* A(x - x') and its first moment N = sum (x + x') / 2 G G'* A. Gaussian moments give
/// E N^2 = sum p p' A^2 (x + x')^2 / 4 and E W^2 = (sum p)^2 + sum p p' A^2, p(x) = E |G|^2 = the
/// integral over y of |2 J1(pi r / rho) / (pi r / rho)|^2. For wide lines it grows with the root
/// of the width, since p falls with the square of x alone: the far rings of a point's picture.
double point_moment_by_square(double sigma_rhos);

/// Pixel's contrast C and correlation length l_c = integral of the normalised covariance along the
/// row, by quadrature of the aperture's covariance |2 J1(pi r / rho) / (pi r / rho)|^2 over the
/// pixel's height: C^2 l_c is what a first moment over many pixels of that height sees.
struct RowSpeckle {
    double contrast = 1, length_mm = 0;
};
RowSpeckle row_speckle(double rho_mm, double height_mm);

}  // namespace stria

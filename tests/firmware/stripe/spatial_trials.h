#pragma once
#include <span>
#include <vector>

#include "firmware/stripe/peak_methods.h"
#include "tests/firmware/stripe/localisation.h"

namespace stria::test {

struct SpatialCondition {
    double width_px;
    double snr;
    bool shot;  ///< half of the peak's variance is its own light's; else additive noise alone
};

/// What each method makes of the same `trials` rows of 48 px, 12 bits, with one stripe each at a
/// random sub-pixel place; a multiple of 500. Errors are from the truth, or from where the same
/// method puts the stripe without noise.
enum class ErrorFrom { truth, noise_free_answer };
std::vector<LocalisationCell> measure_spatial(const SpatialCondition& condition,
                                              std::span<const PeakMethod> methods, int trials,
                                              unsigned seed, ErrorFrom from = ErrorFrom::truth);

/// Localises stripes of 0.6 to 2.5 px width, with additive and with half shot noise, prints rms
/// error over the Cramer-Rao bound for every cell and expects <= 1.05 (1.10 at 0.6 px; plus three
/// standard deviations of the sampling where the trials are fewer than 20 000).
void expect_spatial_reaches_bound(int trials, const std::vector<double>& snrs);

}  // namespace stria::test

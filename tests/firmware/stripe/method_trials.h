#pragma once
#include <vector>

#include "firmware/stripe/peak_methods.h"

namespace stria::test {

/// Greatest error (px) over the sub-pixel phases of a noise-free stripe, 16 bits and 50 000 DN high
/// so that rounding does not count.
double noise_free_bias(PeakMethod method, double width_px);

/// Places stripes of 0.6 to 2.5 px width by every method, with additive noise, and prints rms error
/// over the Cramer-Rao bound and the noise-free bias in one table. Expects the published figures of
/// the methods where there are some, and of the maximum-likelihood fit and the matched filter
/// <= 1.05 (1.10 at 0.6 px); plus three standard deviations of the sampling below 20 000 trials.
void expect_methods_reach_published(int trials, const std::vector<double>& snrs);

/// At SNR 20 and 50: the predicted sigma is within 0.8 to 1.25 of the scatter about the method's
/// own noise-free answer, wherever that is off by less than sigma.
void expect_honest_sigmas(int trials);

}  // namespace stria::test

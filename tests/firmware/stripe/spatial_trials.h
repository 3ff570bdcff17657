#pragma once
#include <vector>

namespace stria::test {

/// Localises stripes of 0.6 to 2.5 px width, with additive and with half shot noise, prints rms
/// error over the Cramer-Rao bound for every cell and expects <= 1.05 (1.10 at 0.6 px; plus three
/// standard deviations of the sampling where the trials are fewer than 20 000).
void expect_spatial_reaches_bound(int trials, const std::vector<double>& snrs);

}  // namespace stria::test

#pragma once
#include <cstddef>
#include <span>

namespace stria {

/// Expected range (greatest minus least) of independent Gaussian residuals with these standard
/// deviations, after the `rejected` ones farthest from zero were left out: what noise alone makes
/// of a form or flatness. Without rejection exact; with it exceedances count as Poisson. In the
/// unit of the sigmas; 0 for fewer than two that are left. Sources: David & Nagaraja, Order
/// Statistics, 2003, section 3.1; Le Cam 1960 for the Poisson step.
double expected_range(std::span<const double> sigmas, std::size_t rejected);

/// The same for `count` residuals of one standard deviation 1.
double expected_range(std::size_t count, std::size_t rejected);

}  // namespace stria

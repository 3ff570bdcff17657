#pragma once

namespace stria {

/// Probability that a chi-square variable of that many degrees of freedom exceeds x: the
/// regularised upper incomplete gamma function Q(dof / 2, x / 2), by its series below and Lentz'
/// continued fraction above dof + 2 (Abramowitz & Stegun 6.5.29, 6.5.31). 1 for x <= 0 or dof <= 0.
double chi_square_tail(double x, double dof);

/// Probability that a standard normal variable exceeds z.
double normal_tail(double z);

}  // namespace stria

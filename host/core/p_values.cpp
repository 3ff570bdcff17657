#include "host/core/p_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stria {
namespace {

constexpr int kMostTerms = 2000;
constexpr double kEnough = 1e-15;

double lower_by_series(double a, double x) {
    double term = 1 / a, sum = term;
    for (int n = 1; n < kMostTerms && std::abs(term) > kEnough * std::abs(sum); ++n) {
        term *= x / (a + n);
        sum += term;
    }
    return sum * std::exp(a * std::log(x) - x - std::lgamma(a));
}

double upper_by_fraction(double a, double x) {
    constexpr double kTiny = std::numeric_limits<double>::min() / kEnough;
    double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, h = d;
    for (int n = 1; n < kMostTerms; ++n) {
        const double an = -n * (n - a);
        b += 2;
        d = an * d + b;
        if (std::abs(d) < kTiny) d = kTiny;
        c = b + an / c;
        if (std::abs(c) < kTiny) c = kTiny;
        d = 1 / d;
        h *= d * c;
        if (std::abs(d * c - 1) < kEnough) break;
    }
    return h * std::exp(a * std::log(x) - x - std::lgamma(a));
}

}  // namespace

double chi_square_tail(double x, double dof) {
    if (!(x > 0) || !(dof > 0)) return 1;
    const double a = 0.5 * dof, half = 0.5 * x;
    const double tail = half < a + 1 ? 1 - lower_by_series(a, half) : upper_by_fraction(a, half);
    return std::clamp(tail, 0.0, 1.0);
}

double normal_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

}  // namespace stria

#include "sim/surface_speckle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/random.h"

namespace stria {
namespace {

constexpr double kMost = 5;  ///< normal deviates; one in two million lies beyond
constexpr int kSteps = 512;
constexpr int kNumbers = 4096;

double normal_share_below(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

/// Where a rising function reaches `value`, between low and high.
template <typename Function>
double bisect(const Function& rising, double value, double low, double high) {
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (rising(middle) < value ? low : high) = middle;
    }
    return (low + high) / 2;
}

/// Share of a gamma distribution of that shape and scale 1 below x: the series of the incomplete
/// gamma function (Abramowitz & Stegun 6.5.29).
double gamma_share_below(double shape, double x) {
    if (x <= 0) return 0;
    double term = 1 / shape, sum = term;
    for (int n = 1; n < 20000 && term > 1e-17 * sum; ++n) {
        term *= x / (shape + n);
        sum += term;
    }
    return sum * std::exp(shape * std::log(x) - x - std::lgamma(shape));
}

std::vector<double> gamma_by_normal(double contrast) {
    const double shape = 1 / (contrast * contrast);
    std::vector<double> values(kSteps + 1);
    for (int i = 0; i <= kSteps; ++i) {
        const double share = normal_share_below(-kMost + 2 * kMost * i / kSteps);
        values[static_cast<std::size_t>(i)] =
            bisect([&](double x) { return gamma_share_below(shape, x); }, share, 0,
                   shape + 12 * std::sqrt(shape) + 20) /
            shape;
    }
    return values;
}

double between(const std::vector<double>& table, double z) {
    const double at = (std::clamp(z, -kMost, kMost) + kMost) / (2 * kMost) * kSteps;
    const auto i = std::min(static_cast<std::size_t>(at), table.size() - 2);
    const double part = at - static_cast<double>(i);
    return table[i] + part * (table[i + 1] - table[i]);
}

/// Weights of the four lattice nodes about a point, `part` of the way from the second to the third:
/// cubic B-spline, squares summing to 1.
std::array<double, 4> spline_weights(double part) {
    const double f = part, g = 1 - part;
    std::array<double, 4> w = {g * g * g, 4 - 3 * f * f * (1 + g), 4 - 3 * g * g * (1 + f),
                               f * f * f};
    const double norm = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
    for (double& weight : w) weight /= norm;
    return w;
}

/// Mean correlation of the field between points `lag` lattice steps apart along a line.
double field_correlation(double lag) {
    constexpr int kPhases = 16;
    const int whole = static_cast<int>(std::floor(lag));
    double sum = 0;
    for (int i = 0; i < kPhases; ++i) {
        const double here = (i + 0.5) / kPhases, there = here + lag - whole;
        const int shift = whole + (there >= 1 ? 1 : 0);
        const auto a = spline_weights(here), b = spline_weights(there >= 1 ? there - 1 : there);
        for (int n = std::max(0, shift); n < 4; ++n)
            sum += a[static_cast<std::size_t>(n)] * b[static_cast<std::size_t>(n - shift)];
    }
    return sum / kPhases;
}

/// Integral over all lags (lattice steps) of the factor's normalised covariance: with Hermite's
/// polynomials, sum of c_k^2 correlation^k over sum of c_k^2.
double length_in_steps(const std::vector<double>& gamma) {
    constexpr int kOrders = 10, kNodes = 1000, kLags = 200;
    std::array<double, kOrders + 1> c{};
    for (int i = 0; i < kNodes; ++i) {
        const double z = -kMost + 2 * kMost * (i + 0.5) / kNodes;
        const double weight = std::exp(-z * z / 2) * between(gamma, z);
        double before = 0, hermite = 1;  // orthonormal
        for (int k = 0; k <= kOrders; ++k) {
            c[static_cast<std::size_t>(k)] += weight * hermite;
            const double next = (z * hermite - std::sqrt(k) * before) / std::sqrt(k + 1);
            before = hermite;
            hermite = next;
        }
    }
    double area = 0, all = 0;
    for (int k = 1; k <= kOrders; ++k) {
        const double share = c[static_cast<std::size_t>(k)] * c[static_cast<std::size_t>(k)];
        all += share;
        for (int i = 0; i < kLags; ++i)
            area +=
                share * 2 * 4.0 / kLags * std::pow(field_correlation(4.0 * (i + 0.5) / kLags), k);
    }
    return area / all;
}

}  // namespace

SurfaceSpeckle::SurfaceSpeckle(const SceneSpeckle& speckle, std::uint64_t seed)
    : seed_(counter_random::mix64(seed) ^ counter_random::kSurfaceSpeckle),
      numbers_(kNumbers),
      gamma_(gamma_by_normal(speckle.contrast)) {
    double square = 0;
    for (int i = 0; i < kNumbers; ++i) {
        const double share = (i + 0.5) / kNumbers;
        const double z = bisect(normal_share_below, share, -6, 6);
        numbers_[static_cast<std::size_t>(i)] = z;
        square += z * z / kNumbers;
    }
    for (double& number : numbers_) number /= std::sqrt(square);
    lattice_mm_ = speckle.length_mm / length_in_steps(gamma_);
}

double SurfaceSpeckle::at(int object, const Eigen::Vector3d& point_in_object) const {
    return between(gamma_, normal_field(object, point_in_object));
}

double SurfaceSpeckle::normal_field(int object, const Eigen::Vector3d& point_in_object) const {
    const Eigen::Array3d at = point_in_object.array() / lattice_mm_;
    const Eigen::Array3d low = at.floor();
    const auto x = spline_weights(at.x() - low.x()), y = spline_weights(at.y() - low.y()),
               z = spline_weights(at.z() - low.z());
    const auto node = [](double whole, std::uint64_t factor) {
        return static_cast<std::uint64_t>(static_cast<std::int64_t>(whole)) * factor;
    };
    // Odd constants of 64 bits: steps along the axes meet again only far outside any scene.
    constexpr std::uint64_t kX = 0x9e3779b97f4a7c15ull, kY = 0xc2b2ae3d27d4eb4full,
                            kZ = 0x165667b19e3779f9ull;
    const std::uint64_t base = counter_random::mix64(seed_ ^ static_cast<std::uint64_t>(object)) +
                               node(low.x() - 1, kX) + node(low.y() - 1, kY) +
                               node(low.z() - 1, kZ);
    double sum = 0;
    for (std::uint64_t i = 0; i < 4; ++i)
        for (std::uint64_t j = 0; j < 4; ++j) {
            double line = 0;
            for (std::uint64_t k = 0; k < 4; ++k) {
                const std::uint64_t bits = counter_random::mix64(base + i * kX + j * kY + k * kZ);
                line += z[k] * numbers_[bits % kNumbers];
            }
            sum += x[i] * y[j] * line;
        }
    return sum;
}

}  // namespace stria

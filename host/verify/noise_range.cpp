#include "host/verify/noise_range.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stria {
namespace {

/// Points of about the same sigma, counted together: a thousand integrand values of a million
/// points each would take minutes.
struct Group {
    double sigma, count;
};
constexpr std::size_t kGroups = 64;

std::vector<Group> grouped(std::span<const double> sigmas) {
    std::vector<double> sorted(sigmas.begin(), sigmas.end());
    std::sort(sorted.begin(), sorted.end());
    std::vector<Group> groups;
    const std::size_t wanted = std::min(kGroups, sorted.size());
    for (std::size_t g = 0; g < wanted; ++g) {
        const std::size_t begin = g * sorted.size() / wanted,
                          end = (g + 1) * sorted.size() / wanted;
        double squares = 0;
        for (std::size_t i = begin; i < end; ++i) squares += sorted[i] * sorted[i];
        const auto count = static_cast<double>(end - begin);
        groups.push_back({std::sqrt(squares / count), count});
    }
    return groups;
}

/// Chance that a normal variable of that sigma exceeds t.
double tail(double t, double sigma) { return 0.5 * std::erfc(t / (sigma * M_SQRT2)); }

/// Expected number of residuals above t.
double expected_above(const std::vector<Group>& groups, double t) {
    double sum = 0;
    for (const Group& group : groups) sum += group.count * tail(t, group.sigma);
    return sum;
}

/// Chance that all of them stay below t.
double chance_all_below(const std::vector<Group>& groups, double t) {
    double log_chance = 0;
    for (const Group& group : groups) log_chance += group.count * std::log1p(-tail(t, group.sigma));
    return std::exp(log_chance);
}

/// Chance of at most k events where `mean` are expected.
double poisson_at_most(std::size_t k, double mean) {
    if (mean <= 0) return 1;
    double sum = 0;
    for (std::size_t i = 0; i <= k; ++i)
        sum += std::exp(static_cast<double>(i) * std::log(mean) - mean -
                        std::lgamma(static_cast<double>(i) + 1));
    return std::min(1.0, sum);
}

/// Midpoint rule over [from, to].
template <typename Function>
double integral(double from, double to, const Function& function) {
    constexpr int kSteps = 600;
    const double step = (to - from) / kSteps;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) sum += function(from + (i + 0.5) * step);
    return sum * step;
}

}  // namespace

double expected_range(std::span<const double> sigmas, std::size_t rejected) {
    if (sigmas.size() < rejected + 2) return 0;
    const std::vector<Group> groups = grouped(sigmas);
    const double reach = 9 * groups.back().sigma;
    if (!(reach > 0)) return 0;
    if (rejected == 0)
        return 2 * (integral(0, reach, [&](double t) { return 1 - chance_all_below(groups, t); }) -
                    integral(-reach, 0, [&](double t) { return chance_all_below(groups, t); }));
    // The farthest that is left, on one side; then how far the other side reaches below it.
    const double farthest = integral(0, reach, [&](double t) {
        return 1 - poisson_at_most(rejected, 2 * expected_above(groups, t));
    });
    const double beyond = expected_above(groups, farthest);
    const double opposite = integral(
        0, farthest, [&](double t) { return 1 - std::exp(beyond - expected_above(groups, t)); });
    return farthest + opposite;
}

double expected_range(std::size_t count, std::size_t rejected) {
    const std::vector<double> ones(count, 1.0);
    return expected_range(ones, rejected);
}

}  // namespace stria

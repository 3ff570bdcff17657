#include "host/scan/clock_delay.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "firmware/core/median.h"
#include "host/scan/compare_directions.h"

namespace stria {
namespace {

constexpr std::size_t kFewestCells = 100;
constexpr double kLeastSigmaNs = 1;       // that of a stamp
constexpr double kMadToSigma = 1.4826;    // of a Gaussian
constexpr double kMedianToMean = 1.2533;  // standard deviation of the median over the mean's

void gather_delays(const PulseMap& a, const PulseMap& b, std::vector<double>& delays_s) {
    for (std::size_t cell = 0; cell + 1 < a.cell_begin.size(); ++cell) {
        const Pulse* one = clean_pulse(a, cell);
        const Pulse* other = clean_pulse(b, cell);
        if (!one || !other || !same_pixel(*one, *other) || one->ds_dt * other->ds_dt >= 0) continue;
        delays_s.push_back(-(one->s - other->s) / (one->ds_dt - other->ds_dt));
    }
}

std::optional<ClockDelay> by_pulses(std::span<const PulseMap> passes) {
    std::vector<double> delays_s;
    for (std::size_t i = 0; i < passes.size(); ++i)
        for (std::size_t k = i + 1; k < passes.size(); ++k)
            if (passes[i].mode == StripeMode::spacetime && passes[k].mode == passes[i].mode &&
                passes[i].cell_begin.size() == passes[k].cell_begin.size())
                gather_delays(passes[i], passes[k], delays_s);
    if (delays_s.size() < kFewestCells) return std::nullopt;
    const double middle = median(delays_s);
    std::vector<double> deviations;
    for (const double delay : delays_s) deviations.push_back(std::abs(delay - middle));
    ClockDelay result;
    result.cells = delays_s.size();
    result.delay_ns = 1e9 * middle;
    result.sigma_ns =
        std::max(kLeastSigmaNs, 1e9 * kMedianToMean * kMadToSigma * median(std::move(deviations)) /
                                    std::sqrt(static_cast<double>(result.cells)));
    return result;
}

/// One row's stripe over a pass.
struct Crossing {
    double s, u, speed;
    int frame;
};
using RowTrace = std::vector<Crossing>;

/// A row's single unflagged peaks, s ascending.
RowTrace trace_of(const PulseMap& map, int row, std::uint8_t laser) {
    RowTrace trace;
    for (int k = 0; k < map.width; ++k) {
        const auto cell = map.cell(k, row);
        if (cell.size() != 1 || cell[0].flags != 0 || cell[0].laser_id != laser) continue;
        trace.push_back({cell[0].s, static_cast<double>(cell[0].u), cell[0].ds_dt, k});
    }
    std::sort(trace.begin(), trace.end(),
              [](const Crossing& a, const Crossing& b) { return a.s < b.s; });
    return trace;
}

/// The stripe as one pass saw it where the other did.
struct Compared {
    double u = 0;      ///< column expected
    double slope = 0;  ///< px per unit of s
    double speed = 0;  ///< of the axis in that pass
};

/// Parabola through the `kAround` peaks on either side of s; empty at gaps and jumps, or where they
/// stand at too few positions.
std::optional<Compared> column_at(const RowTrace& trace, double s) {
    constexpr std::ptrdiff_t kAround = 4;
    constexpr double kMostStepPx = 2;
    const auto next = std::lower_bound(trace.begin(), trace.end(), s,
                                       [](const Crossing& c, double at) { return c.s < at; });
    if (next - trace.begin() < kAround || trace.end() - next < kAround) return std::nullopt;
    const auto first = next - kAround;
    const double half = 0.5 * ((next + kAround - 1)->s - first->s);
    if (!(half > 0)) return std::nullopt;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (auto c = first; c != next + kAround; ++c) {
        if (c != first && (std::abs(c->u - (c - 1)->u) > kMostStepPx ||
                           c->s - (c - 1)->s > half))  // 7 steps are 2 halves
            return std::nullopt;
        const double t = (c->s - s) / half;
        const Eigen::Vector3d powers(1, t, t * t);
        normal += powers * powers.transpose();
        right += c->u * powers;
    }
    const Eigen::Vector3d parabola = normal.inverse() * right;
    if (!parabola.allFinite()) return std::nullopt;
    return Compared{parabola[0], parabola[1] / half, next->speed};
}

/// Differences d = x delay of the passes' columns.
struct ColumnDifferences {
    std::vector<double> x, d;
    std::vector<std::size_t> frame;  ///< of the second pass
    std::size_t frames = 0;
};

/// @param delay_s  taken out of both passes first
ColumnDifferences compare_traces(const std::vector<std::pair<RowTrace, RowTrace>>& rows,
                                 double delay_s) {
    ColumnDifferences all;
    for (const auto& [one, other] : rows) {
        RowTrace moved = one;
        for (Crossing& c : moved) c.s += c.speed * delay_s;
        for (const Crossing& c : other) {
            const auto expected = column_at(moved, c.s + c.speed * delay_s);
            if (!expected) continue;
            all.x.push_back(expected->slope * (c.speed - expected->speed));
            all.d.push_back(c.u - expected->u);
            all.frame.push_back(static_cast<std::size_t>(c.frame));
            all.frames = std::max(all.frames, all.frame.back() + 1);
        }
    }
    return all;
}

/// The delay with the least sum of |d - x delay|: the median of d / x, each weighing |x|.
double least_absolute(const ColumnDifferences& all) {
    std::vector<std::pair<double, double>> quotients;
    double total = 0;
    for (std::size_t i = 0; i < all.x.size(); ++i) {
        if (all.x[i] == 0) continue;
        quotients.emplace_back(all.d[i] / all.x[i], std::abs(all.x[i]));
        total += std::abs(all.x[i]);
    }
    std::sort(quotients.begin(), quotients.end());
    double sum = 0;
    for (const auto& [delay, weight] : quotients)
        if ((sum += weight) >= 0.5 * total) return delay;
    return 0;
}

/// Of both passes' noise: the second's by the scatter of its frames' sums, because the peaks of a
/// frame share what the axis trembles by; the first's counts as much, through the parabolas that it
/// bends.
double sigma_of_delay(const ColumnDifferences& all) {
    constexpr double kClipped = 2.5;  // sigmas: strays have a say, not a vote each
    std::vector<double> deviations;
    for (const double d : all.d) deviations.push_back(std::abs(d));
    const double most = kClipped * kMadToSigma * median(std::move(deviations));
    std::vector<double> sums(all.frames, 0);
    double squares = 0, scatter = 0;
    for (std::size_t i = 0; i < all.x.size(); ++i) {
        sums[all.frame[i]] += all.x[i] * std::clamp(all.d[i], -most, most);
        squares += all.x[i] * all.x[i];
    }
    for (const double sum : sums) scatter += sum * sum;
    return squares > 0 ? std::sqrt(2 * scatter) / squares : 0;
}

std::optional<ClockDelay> delay_of_traces(const PulseMap& a, const PulseMap& b) {
    constexpr int kMostRounds = 20;
    std::vector<std::pair<RowTrace, RowTrace>> rows;
    const std::uint8_t laser = a.pulses.front().laser_id;
    for (int row = 0; row < a.height; ++row)
        rows.emplace_back(trace_of(a, row, laser), trace_of(b, row, laser));
    double delay_s = 0, step = 0, share = 1;
    for (int round = 0; round < kMostRounds; ++round) {
        const ColumnDifferences all = compare_traces(rows, delay_s);
        if (all.x.size() < kFewestCells) return std::nullopt;
        const double sigma = std::max(1e-9 * kLeastSigmaNs, sigma_of_delay(all));
        // Which peaks bracket which changes with the delay, so that full steps may go to and fro.
        const double wanted = least_absolute(all);
        if (wanted * step < 0) share *= 0.5;
        step = share * wanted;
        delay_s += step;
        if (std::abs(step) < 0.02 * sigma)
            return ClockDelay{1e9 * delay_s, 1e9 * sigma, all.x.size()};
    }
    return std::nullopt;
}

std::optional<ClockDelay> by_peaks(std::span<const PulseMap> passes) {
    std::vector<ClockDelay> delays;
    for (std::size_t i = 0; i < passes.size(); ++i)
        for (std::size_t k = i + 1; k < passes.size(); ++k) {
            const PulseMap &a = passes[i], &b = passes[k];
            if (a.pulses.empty() || b.pulses.empty() || a.height != b.height ||
                a.pulses.front().laser_id != b.pulses.front().laser_id ||
                a.pulses.front().ds_dt * b.pulses.front().ds_dt >= 0)
                continue;
            if (const auto delay = delay_of_traces(a, b)) delays.push_back(*delay);
        }
    if (delays.empty()) return std::nullopt;
    return mean_of(delays);
}

}  // namespace

std::optional<ClockDelay> clock_delay(std::span<const PulseMap> passes) {
    if (passes.empty()) return std::nullopt;
    return passes.front().mode == StripeMode::spatial ? by_peaks(passes) : by_pulses(passes);
}

ClockDelay mean_of(std::span<const ClockDelay> delays) {
    ClockDelay mean;
    double weight = 0, chi_square = 0;
    for (const ClockDelay& one : delays) {
        weight += 1 / (one.sigma_ns * one.sigma_ns);
        mean.delay_ns += one.delay_ns / (one.sigma_ns * one.sigma_ns);
        mean.cells += one.cells;
    }
    mean.delay_ns /= weight;
    for (const ClockDelay& one : delays)
        chi_square += std::pow((one.delay_ns - mean.delay_ns) / one.sigma_ns, 2);
    const double degrees = static_cast<double>(std::max<std::size_t>(delays.size(), 2) - 1);
    mean.sigma_ns = std::sqrt(std::max(1.0, chi_square / degrees) / weight);
    return mean;
}

void apply_delay(PulseMap& map, double delay_ns) {
    for (Pulse& pulse : map.pulses) pulse.s += pulse.ds_dt * 1e-9 * delay_ns;
}

}  // namespace stria

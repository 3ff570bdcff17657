#include "tests/host/cli/rotated_spacetime.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stria::test_support {
namespace {

constexpr double kReachWidths = 3;
constexpr int kRounds = 4;  // of the window about its own mean

std::array<double, 4> cubic_weights(double f) {
    const double f2 = f * f, f3 = f2 * f;
    return {-0.5 * f3 + f2 - 0.5 * f, 1.5 * f3 - 2.5 * f2 + 1, -1.5 * f3 + 2 * f2 + 0.5 * f,
            0.5 * f3 - 0.5 * f2};
}

/// One scan line over time; no light outside.
struct SpacetimeImage {
    std::span<const Frame> frames;
    int row;

    double sample(int k, int u) const {
        if (k < 0 || u < 0 || k >= static_cast<int>(frames.size()) || u >= frames[0].width)
            return 0;
        return frames[static_cast<std::size_t>(k)].sample(u, row);
    }
    double at(double k, double u) const {
        const int k0 = static_cast<int>(std::floor(k)), u0 = static_cast<int>(std::floor(u));
        const auto over_k = cubic_weights(k - k0), over_u = cubic_weights(u - u0);
        double value = 0;
        for (int j = 0; j < 4; ++j)
            for (int i = 0; i < 4; ++i)
                value += over_k[static_cast<std::size_t>(i)] * over_u[static_cast<std::size_t>(j)] *
                         sample(k0 - 1 + i, u0 - 1 + j);
        return value;
    }
};

/// Mean of the light about the sample `peak` of a column, three widths to each side.
double mean_about(const std::vector<double>& column, int peak, double width) {
    double mean = peak;
    for (int round = 0; round < kRounds; ++round) {
        double sum = 0, moment = 0;
        for (int b = 0; b < static_cast<int>(column.size()); ++b) {
            // the window's ends count in part, so that the mean moves smoothly with them
            const double inside =
                std::clamp(kReachWidths * width + 0.5 - std::abs(b - mean), 0.0, 1.0);
            const double light = inside * column[static_cast<std::size_t>(b)];
            sum += light;
            moment += light * b;
        }
        mean = moment / sum;
    }
    return mean;
}

}  // namespace

std::vector<SpacetimeMean> rotated_spacetime_means(std::span<const Frame> frames, int row,
                                                   const RotationOptions& options) {
    const SpacetimeImage image{frames, row};
    const double stretch = std::hypot(1.0, options.slope_px);
    const double cosine = 1 / stretch, sine = options.slope_px / stretch;  // of a path's direction
    const double width = options.width_frames * stretch;  // of a pulse along the turned columns
    const double mid_k = 0.5 * static_cast<double>(frames.size()), mid_u = 0.5 * frames[0].width;
    const int half = static_cast<int>(std::ceil(std::hypot(mid_k, mid_u)));
    const int apart = std::max(1, static_cast<int>(width));
    std::vector<SpacetimeMean> means;
    std::vector<double> column(static_cast<std::size_t>(2 * half + 1));
    for (int a = -half; a <= half; ++a) {
        const auto k_of = [&](double b) { return mid_k + (b - half) * cosine - a * sine; };
        const auto u_of = [&](double b) { return mid_u + (b - half) * sine + a * cosine; };
        for (std::size_t b = 0; b < column.size(); ++b)
            column[b] = image.at(k_of(static_cast<double>(b)), u_of(static_cast<double>(b)));
        for (int b = apart; b + apart < static_cast<int>(column.size()); ++b) {
            const auto here = column.begin() + b;
            if (*here < options.least_dn || *std::max_element(here - apart, here) > *here ||
                *std::max_element(here + 1, here + apart + 1) >= *here)
                continue;
            const double mean = mean_about(column, b, width);
            means.push_back({u_of(mean), static_cast<double>(row), k_of(mean), *here});
        }
    }
    return means;
}

}  // namespace stria::test_support

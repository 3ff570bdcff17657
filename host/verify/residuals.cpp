#include "host/verify/residuals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "firmware/core/median.h"
#include "host/verify/noise_range.h"

namespace stria {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double range_of_values(const std::vector<double>& sorted) { return sorted.back() - sorted.front(); }

/// Width of the narrowest shell that holds 95 % of the sorted values.
double shell_of_95_percent(const std::vector<double>& sorted) {
    const auto inside =
        static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(sorted.size())));
    double width = range_of_values(sorted);
    for (std::size_t i = 0; i + inside <= sorted.size(); ++i)
        width = std::min(width, sorted[i + inside - 1] - sorted[i]);
    return width;
}

double rms(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value * value;
    return std::sqrt(sum / static_cast<double>(values.size()));
}

void predict(FormFigures& figures, const ScanPoints& points,
             const std::vector<Eigen::Vector3d>& normals) {
    std::vector<double> random, systematic, normalised;
    for (std::size_t i = 0; i < normals.size(); ++i) {
        random.push_back(random_along(points.noise[i], normals[i]));
        systematic.push_back(systematic_along(points.noise[i], normals[i]));
        normalised.push_back(std::abs(figures.residuals_mm[i]) / random.back());
    }
    figures.predicted_sigma_mm = rms(random);
    figures.predicted_systematic_mm = points.has_systematic() ? rms(systematic) : kUnknown;
    figures.expected_form_mm = expected_range(random, figures.rejected);
    figures.sigma_ratio = 1.4826 * median(normalised);
    figures.form_ratio = figures.form_mm / figures.predicted_sigma_mm;
    figures.point_sigmas_mm = std::move(random);
}

}  // namespace

std::size_t most_rejected(std::size_t count) { return count * 3 / 1000; }

std::vector<std::uint8_t> keep_mask(const std::vector<double>& residuals, std::size_t rejected) {
    std::vector<std::uint32_t> order(residuals.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const double far_a = std::abs(residuals[a]), far_b = std::abs(residuals[b]);
        return far_a != far_b ? far_a > far_b : a > b;
    });
    std::vector<std::uint8_t> kept(residuals.size(), 1);
    for (std::size_t i = 0; i < std::min(rejected, order.size()); ++i) kept[order[i]] = 0;
    return kept;
}

FormFigures form_figures(std::vector<double> residuals_mm, std::vector<std::uint8_t> kept,
                         int parameters, const ScanPoints& points,
                         const std::vector<Eigen::Vector3d>& normals) {
    FormFigures figures;
    std::vector<double> all = residuals_mm, used;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (kept[i] != 0) used.push_back(all[i]);
    figures.residuals_mm = std::move(residuals_mm);
    figures.kept = std::move(kept);
    figures.points_used = used.size();
    figures.rejected = all.size() - used.size();
    const double freedom = std::max(1.0, static_cast<double>(used.size()) - parameters);
    figures.sigma_mm = rms(used) * std::sqrt(static_cast<double>(used.size()) / freedom);
    std::sort(all.begin(), all.end());
    std::sort(used.begin(), used.end());
    figures.form_mm = range_of_values(used);
    figures.form_all_mm = range_of_values(all);
    figures.d95_mm = shell_of_95_percent(all);
    figures.predicted_sigma_mm = figures.predicted_systematic_mm = figures.expected_form_mm =
        figures.sigma_ratio = figures.form_ratio = kUnknown;
    if (points.has_noise()) predict(figures, points, normals);
    return figures;
}

}  // namespace stria

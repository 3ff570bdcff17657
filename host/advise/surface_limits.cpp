#include "host/advise/surface_limits.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stria {
namespace {

double shift_at(double d, double k) {
    const double density = std::exp(-0.5 * d * d) / std::sqrt(2 * std::numbers::pi);
    const double bright = 0.5 * std::erfc(-d / std::numbers::sqrt2);
    return (1 - 1 / k) * density / (bright + (1 - bright) / k);
}

}  // namespace

double reflectance_step_shift(double ratio) {
    const double k = std::max(ratio, 1 / ratio);
    double low = -6, high = 0;  // one maximum, on the dark side
    for (int i = 0; i < 100; ++i) {
        const double a = low + (high - low) / 3, b = high - (high - low) / 3;
        if (shift_at(a, k) < shift_at(b, k))
            low = a;
        else
            high = b;
    }
    return shift_at((low + high) / 2, k);
}

EdgeError edge_error(double reflectance_ratio, double sigma_p_mm, double sigma_b_mm,
                     double triangulation_rad) {
    const double shift = reflectance_step_shift(reflectance_ratio);
    const double on_surface_mm = sigma_b_mm / std::cos(triangulation_rad);
    EdgeError error;
    // A shift x on the surface is x / tan(angle) in depth, both ways.
    error.spatial_mm = shift * on_surface_mm / std::tan(triangulation_rad);
    error.spacetime_mm = shift * sigma_p_mm / std::tan(triangulation_rad);
    error.ratio = sigma_p_mm / on_surface_mm;
    return error;
}

Occlusion occlusion_of(double triangulation_rad) {
    Occlusion seen;
    seen.hemisphere_share = 1 - triangulation_rad / std::numbers::pi;
    seen.steepest_wall_rad = std::numbers::pi / 2 - triangulation_rad;
    seen.hole_depth_per_width = 0.5 / std::tan(triangulation_rad);
    seen.best_hole_depth_per_width = 0.5 / std::tan(triangulation_rad / 2);
    return seen;
}

}  // namespace stria

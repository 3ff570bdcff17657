#include "sim/form_factor.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

namespace stria {
namespace {

/// Corners as seen from the point; cutting a quadrilateral at a plane adds at most one.
struct Polygon {
    std::array<Eigen::Vector3d, 5> corners;
    int count = 0;
    void add(const Eigen::Vector3d& p) { corners[static_cast<std::size_t>(count++)] = p; }
    const Eigen::Vector3d& at(int i) const { return corners[static_cast<std::size_t>(i % count)]; }
};

Polygon above_horizon(const Polygon& all, const Eigen::Vector3d& normal) {
    Polygon kept;
    for (int i = 0; i < all.count; ++i) {
        const Eigen::Vector3d &a = all.at(i), &b = all.at(i + 1);
        const double height_a = normal.dot(a), height_b = normal.dot(b);
        if (height_a > 0) kept.add(a);
        if ((height_a > 0) != (height_b > 0) && kept.count < 5)
            kept.add(a + height_a / (height_a - height_b) * (b - a));
    }
    return kept;
}

}  // namespace

double parallelogram_irradiance(const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                                const Eigen::Vector3d& centre, const Eigen::Vector3d& half_a,
                                const Eigen::Vector3d& half_b) {
    const Eigen::Vector3d c = centre - point;
    Polygon all;
    all.add(c + half_a + half_b);
    all.add(c - half_a + half_b);
    all.add(c - half_a - half_b);
    all.add(c + half_a - half_b);
    const Polygon seen = above_horizon(all, normal);
    if (seen.count < 3) return 0;
    double sum = 0;
    for (int i = 0; i < seen.count; ++i) {
        const Eigen::Vector3d across = seen.at(i).cross(seen.at(i + 1));
        const double length = across.norm();
        if (!(length > 0)) continue;
        sum += std::atan2(length, seen.at(i).dot(seen.at(i + 1))) * normal.dot(across) / length;
    }
    return std::abs(sum) / 2;
}

}  // namespace stria

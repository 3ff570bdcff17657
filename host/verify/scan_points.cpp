#include "host/verify/scan_points.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

/// Square of the cosine between a point's error direction and another one.
double share_along(const PointNoise& noise, const Eigen::Vector3d& along) {
    const double cosine = noise.direction.cast<double>().dot(along);
    return std::min(1.0, cosine * cosine);
}

}  // namespace

ScanPoints scan_points(const RangeImage& image) {
    ScanPoints scan;
    bool all_known = true;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell) {
        if (image.mask[cell] == 0) continue;
        const RangePoint& point = image.points[cell];
        scan.positions.push_back(point.position);
        scan.towards_camera.push_back(direction_to_camera(image, point).cast<float>());
        scan.noise.push_back({point.error_direction, point.sigma_mm, point.sigma_across_mm,
                              point.sigma_systematic_mm});
        all_known = all_known && point.sigma_mm > 0 && point.error_direction.norm() > 0.5F;
    }
    if (!all_known) scan.noise.clear();
    return scan;
}

ScanPoints scan_points(const PointCloud& cloud) { return {cloud.positions, {}, {}}; }

ScanPoints chosen(const ScanPoints& scan, const std::vector<std::uint32_t>& indices) {
    ScanPoints out;
    for (const std::uint32_t i : indices) {
        out.positions.push_back(scan.positions[i]);
        if (scan.has_sight()) out.towards_camera.push_back(scan.towards_camera[i]);
        if (scan.has_noise()) out.noise.push_back(scan.noise[i]);
    }
    return out;
}

double random_along(const PointNoise& noise, const Eigen::Vector3d& along) {
    const double share = share_along(noise, along);
    return std::sqrt(share * std::pow(static_cast<double>(noise.sigma_mm), 2) +
                     (1 - share) * std::pow(static_cast<double>(noise.across_mm), 2));
}

double systematic_along(const PointNoise& noise, const Eigen::Vector3d& along) {
    return std::sqrt(share_along(noise, along)) * static_cast<double>(noise.systematic_mm);
}

}  // namespace stria

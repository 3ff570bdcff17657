#include "host/verify/scan_points.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

/// Appends what a point states of each calibration error.
void add_sensitivity(ScanPoints& scan, const std::vector<float>& all, std::size_t index) {
    const auto count = static_cast<std::size_t>(scan.sensitivity_count);
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(index * count);
    scan.sensitivity.insert(scan.sensitivity.end(), first,
                            first + static_cast<std::ptrdiff_t>(count));
}

/// Square of the cosine between a point's error direction and another one.
double share_along(const PointNoise& noise, const Eigen::Vector3d& along) {
    const double cosine = noise.direction.cast<double>().dot(along);
    return std::min(1.0, cosine * cosine);
}

}  // namespace

ScanPoints scan_points(const RangeImage& image) {
    ScanPoints scan;
    scan.sensitivity_count = image.sensitivity_count;
    bool all_known = true;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell) {
        if (image.mask[cell] == 0) continue;
        const RangePoint& point = image.points[cell];
        scan.positions.push_back(point.position);
        scan.towards_camera.push_back(direction_to_camera(image, point).cast<float>());
        scan.noise.push_back({point.error_direction, point.sigma_mm, point.sigma_across_mm,
                              point.sigma_systematic_mm});
        add_sensitivity(scan, image.sensitivity, cell);
        all_known = all_known && point.sigma_mm > 0 && point.error_direction.norm() > 0.5F;
    }
    if (!all_known) scan.noise.clear();
    return scan;
}

ScanPoints scan_points(const PointCloud& cloud) {
    ScanPoints scan;
    scan.positions = cloud.positions;
    return scan;
}

ScanPoints chosen(const ScanPoints& scan, const std::vector<std::uint32_t>& indices) {
    ScanPoints out;
    out.sensitivity_count = scan.sensitivity_count;
    for (const std::uint32_t i : indices) {
        out.positions.push_back(scan.positions[i]);
        if (scan.has_sight()) out.towards_camera.push_back(scan.towards_camera[i]);
        if (scan.has_noise()) out.noise.push_back(scan.noise[i]);
        add_sensitivity(out, scan.sensitivity, i);
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

#include "tests/host/fusion/fusion_scenes.h"

#include <Eigen/Geometry>
#include <cmath>

namespace stria {

RangeImage orthographic_image(double half_mm, double pitch_mm,
                              const std::function<double(double, double)>& z) {
    const int cells = 2 * static_cast<int>(std::round(half_mm / pitch_mm)) + 1;
    RangeImage image = make_range_image(cells, cells);
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            const double x = i * pitch_mm - half_mm, y = j * pitch_mm - half_mm;
            const double height = z(x, y);
            if (std::isnan(height)) continue;
            image.mask[image.cell(i, j)] = 1;
            image.points[image.cell(i, j)].position = {x, y, height};
        }
    return image;
}

RangeImage perspective_image(const Eigen::Vector3d& laser, double half_angle_rad, int cells,
                             const std::function<double(const Eigen::Vector3d&)>& range) {
    RangeImage image = make_range_image(cells, cells);
    image.stations = {{.s = 0, .camera_in_scan = Eigen::Vector3d::Zero(), .laser_in_scan = laser}};
    const double edge = std::tan(half_angle_rad);
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i) {
            const Eigen::Vector3d ray = Eigen::Vector3d(edge * (2.0 * i / (cells - 1) - 1),
                                                        edge * (1 - 2.0 * j / (cells - 1)), -1)
                                            .normalized();
            const double mm = range(ray);
            if (std::isnan(mm)) continue;
            image.mask[image.cell(i, j)] = 1;
            image.points[image.cell(i, j)].position = mm * ray;
        }
    return image;
}

Rigid3 looking_from(const Eigen::Vector3d& up, const Eigen::Vector3d& at) {
    return {Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), up).toRotationMatrix(),
            at};
}

std::vector<Eigen::Vector3d> icosahedron_directions() {
    const double golden = (1 + std::sqrt(5.0)) / 2;
    std::vector<Eigen::Vector3d> directions;
    for (const double one : {-1.0, 1.0})
        for (const double g : {-golden, golden}) {
            directions.push_back(Eigen::Vector3d(0, one, g).normalized());
            directions.push_back(Eigen::Vector3d(one, g, 0).normalized());
            directions.push_back(Eigen::Vector3d(g, 0, one).normalized());
        }
    return directions;
}

std::vector<FuseScan> Scans::list() const {
    std::vector<FuseScan> scans;
    for (std::size_t i = 0; i < images.size(); ++i) scans.push_back({&images[i], poses[i]});
    return scans;
}

Scans sphere_scans(double radius_mm, double pitch_mm, double noise_mm) {
    std::mt19937 rng(5);
    std::normal_distribution<double> unit;
    Scans scans;
    for (const Eigen::Vector3d& direction : icosahedron_directions()) {
        scans.images.push_back(
            orthographic_image(radius_mm + pitch_mm, pitch_mm, [&](double x, double y) {
                const double squared = radius_mm * radius_mm - x * x - y * y;
                return squared < 0 ? std::nan("") : std::sqrt(squared) + noise_mm * unit(rng);
            }));
        scans.poses.push_back(looking_from(direction));
    }
    return scans;
}

}  // namespace stria

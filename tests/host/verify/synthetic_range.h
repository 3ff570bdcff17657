#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <random>
#include <vector>

#include "host/core/range_image.h"

/// Range images of spheres and planes, ray by ray in closed form, from a camera at the origin that
/// looks along -z, as swept scans are.
namespace stria::test_support {

struct Ball {
    Eigen::Vector3d centre;
    double radius_mm;
};
/// Rectangle centre + a edge_a + b edge_b, |a|, |b| <= 1/2.
struct Tile {
    Eigen::Vector3d centre, edge_a, edge_b;
};

struct SyntheticRange {
    std::vector<Ball> balls;
    std::vector<Tile> tiles;
    double sigma_mm = 0.01;        ///< along the ray
    double systematic_mm = 0.005;  ///< stated; no error is made of it
    int width = 400, height = 300;
    double focal_px = 600;
};

inline std::optional<double> ray_hit(const Ball& ball, const Eigen::Vector3d& ray) {
    const double along = ray.dot(ball.centre);
    const double root = along * along - ball.centre.squaredNorm() + ball.radius_mm * ball.radius_mm;
    if (root < 0) return {};
    return along - std::sqrt(root);
}

inline std::optional<double> ray_hit(const Tile& tile, const Eigen::Vector3d& ray) {
    const Eigen::Vector3d normal = tile.edge_a.cross(tile.edge_b);
    const double range = normal.dot(tile.centre) / normal.dot(ray);
    const Eigen::Vector3d off = range * ray - tile.centre;
    const auto beyond = [&](const Eigen::Vector3d& edge) {
        return std::abs(off.dot(edge)) > 0.5 * edge.squaredNorm();
    };
    if (!(range > 0) || beyond(tile.edge_a) || beyond(tile.edge_b)) return {};
    return range;
}

inline RangeImage make_range(const SyntheticRange& scene, unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> gauss;
    RangeImage image = make_range_image(scene.width, scene.height);
    image.stations = {Station{0, Eigen::Vector3d::Zero(), Eigen::Vector3d(200, 0, 0)}};
    for (int y = 0; y < scene.height; ++y) {
        for (int x = 0; x < scene.width; ++x) {
            const Eigen::Vector3d ray =
                Eigen::Vector3d((x - 0.5 * scene.width) / scene.focal_px,
                                -(y - 0.5 * scene.height) / scene.focal_px, -1)
                    .normalized();
            std::optional<double> range;
            const auto nearer = [&](const std::optional<double>& hit) {
                if (hit && (!range || *hit < *range)) range = hit;
            };
            for (const Ball& ball : scene.balls) nearer(ray_hit(ball, ray));
            for (const Tile& tile : scene.tiles) nearer(ray_hit(tile, ray));
            if (!range) continue;
            RangePoint& point = image.points[image.cell(x, y)];
            image.mask[image.cell(x, y)] = 1;
            point.position = (*range + scene.sigma_mm * gauss(rng)) * ray;
            point.error_direction = ray.cast<float>();
            point.sigma_mm = static_cast<float>(scene.sigma_mm);
            point.sigma_systematic_mm = static_cast<float>(scene.systematic_mm);
            point.intensity = 100;
        }
    }
    return image;
}

}  // namespace stria::test_support

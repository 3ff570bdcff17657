#include "tests/support/bumpy_shape.h"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

namespace stria::testing {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

struct Bump {
    Vector3d towards;
    double height_mm, width_rad;
};

Vector3d random_direction(std::mt19937& rng) {
    std::normal_distribution<double> n(0.0, 1.0);
    Vector3d d;
    do d = Vector3d(n(rng), n(rng), n(rng));
    while (d.norm() < 1e-3);
    return d.normalized();
}

std::vector<Bump> make_bumps(unsigned seed) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> u(-1.0, 1.0);
    std::vector<Bump> bumps;
    for (int i = 0; i < 6; ++i)
        bumps.push_back({random_direction(rng), 12 * u(rng), 0.6 + 0.2 * u(rng)});
    for (int i = 0; i < 40; ++i)
        bumps.push_back({random_direction(rng), 4 * u(rng), 0.2 + 0.05 * u(rng)});
    for (int i = 0; i < 120; ++i)
        bumps.push_back({random_direction(rng), 1.0 * u(rng), 0.08 + 0.02 * u(rng)});
    return bumps;
}

double radius_mm(const Vector3d& direction, const std::vector<Bump>& bumps) {
    double radius = 45;
    for (const Bump& bump : bumps) {
        const double angle = std::acos(std::clamp(direction.dot(bump.towards), -1.0, 1.0));
        radius += bump.height_mm * std::exp(-0.5 * std::pow(angle / bump.width_rad, 2));
    }
    return radius;
}

/// Unit icosphere: every triangle cut in four, `level` times.
TriMesh icosphere(int level) {
    const double t = std::numbers::phi;
    TriMesh mesh;
    mesh.positions = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                      {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
    for (Vector3d& p : mesh.positions) p.normalize();
    mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                      {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                      {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                      {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (int round = 0; round < level; ++round) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto key = std::minmax(a, b);
            const auto [at, is_new] =
                middles.try_emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
            if (is_new)
                mesh.positions.push_back((mesh.positions[a] + mesh.positions[b]).normalized());
            return at->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto& [a, b, c] : mesh.triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        mesh.triangles = std::move(finer);
    }
    return mesh;
}

}  // namespace

TriMesh make_bumpy_shape(unsigned seed, int level) {
    const std::vector<Bump> bumps = make_bumps(seed);
    TriMesh mesh = icosphere(level);
    for (Vector3d& p : mesh.positions) p *= radius_mm(p, bumps);
    return mesh;
}

Rigid3 looking_from(const Vector3d& direction, double distance_mm, double roll_rad) {
    const Vector3d z = direction.normalized();  // the camera looks along -z
    const Vector3d x = z.unitOrthogonal();
    Eigen::Matrix3d axes;
    axes << x, z.cross(x), z;
    return {axes * Eigen::AngleAxisd(roll_rad, Vector3d::UnitZ()).toRotationMatrix(),
            distance_mm * z};
}

RangeImage take_view(const SurfaceTree& shape, const Rigid3& world_from_scan,
                     const ViewOptions& options, std::mt19937& rng) {
    std::normal_distribution<double> noise(0.0, 1.0);
    RangeImage image = make_range_image(options.width, options.height);
    const Vector3d laser(options.baseline_mm, 0, 0);
    image.stations = {{.s = 0, .camera_in_scan = Vector3d::Zero(), .laser_in_scan = laser}};
    const Vector3d camera_in_world = world_from_scan.translation;
    const Vector3d laser_in_world = world_from_scan * laser;
    for (int y = 0; y < options.height; ++y)
        for (int x = 0; x < options.width; ++x) {
            const Vector3d ray =
                Vector3d((x - 0.5 * (options.width - 1)) * options.pitch_mm,
                         (0.5 * (options.height - 1) - y) * options.pitch_mm, -options.distance_mm)
                    .normalized();
            const Vector3d ray_in_world = world_from_scan.rotation * ray;
            const auto hit = shape.first_hit(camera_in_world, ray_in_world);
            if (!hit) continue;
            const Vector3d point_in_world = camera_in_world + hit->t * ray_in_world;
            if (shape.first_hit(laser_in_world, point_in_world - laser_in_world, 0, 1 - 1e-6))
                continue;  // in the laser's shadow
            const std::size_t cell = image.cell(x, y);
            image.mask[cell] = 1;
            RangePoint& point = image.points[cell];
            point.position = (hit->t + options.sigma_mm * noise(rng)) * ray;
            point.error_direction = ray.cast<float>();
            point.sigma_mm = static_cast<float>(options.sigma_mm);
        }
    return image;
}

std::vector<Vector3d> spread_directions(int count) {
    std::vector<Vector3d> directions;
    const double golden_angle = kPi * (3 - std::sqrt(5.0));
    for (int i = 0; i < count; ++i) {
        const double z = 1 - (2.0 * i + 1) / count;
        const double r = std::sqrt(1 - z * z);
        directions.emplace_back(r * std::cos(golden_angle * i), r * std::sin(golden_angle * i), z);
    }
    return directions;
}

Rigid3 random_motion(const Vector3d& centre, double angle_rad, double shift_mm, std::mt19937& rng) {
    const Eigen::Matrix3d rotation = rotation_from_vector(angle_rad * random_direction(rng));
    return {rotation, centre - rotation * centre + shift_mm * random_direction(rng)};
}

}  // namespace stria::testing

#include "host/cli/demo/sculpture_truth.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "host/geometry/nearest.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

using Eigen::Vector3d;

Vector3d triangle_normal(const TriMesh& mesh, std::size_t t) {
    const auto& c = mesh.triangles[t];
    const Vector3d& a = mesh.positions[c[0]];
    return (mesh.positions[c[1]] - a).cross(mesh.positions[c[2]] - a);
}

/// Points every 0.3 mm along edges that are sharp (above 20 deg) or border a patch.
std::vector<Vector3d> sharp_edge_points(const TriMesh& mesh) {
    struct Sides {
        std::vector<std::size_t> triangles;
    };
    std::map<std::pair<std::uint32_t, std::uint32_t>, Sides> edges;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const auto a = mesh.triangles[t][static_cast<std::size_t>(k)];
            const auto b = mesh.triangles[t][static_cast<std::size_t>((k + 1) % 3)];
            edges[std::minmax(a, b)].triangles.push_back(t);
        }
    std::vector<Vector3d> points;
    for (const auto& [edge, sides] : edges) {
        const Vector3d &a = mesh.positions[edge.first], &b = mesh.positions[edge.second];
        const double length = (b - a).norm();
        if (length < 1e-9) continue;  // the collapsed row at a pole
        if (sides.triangles.size() == 2) {
            const Vector3d n0 = triangle_normal(mesh, sides.triangles[0]).normalized();
            const Vector3d n1 = triangle_normal(mesh, sides.triangles[1]).normalized();
            if (n0.dot(n1) > std::cos(20.0 / 57.29577951308232)) continue;
        }
        const int count = std::max(1, static_cast<int>(length / 0.3));
        for (int i = 0; i < count; ++i) points.emplace_back(a + (b - a) * (i + 0.5) / count);
    }
    return points;
}

}  // namespace

struct SculptureTruth::Trees {
    std::unique_ptr<SurfaceTree> whole;
    std::vector<SurfaceTree> parts;
    std::unique_ptr<PointTree> sharp;
};

SculptureTruth::SculptureTruth(const std::vector<SculpturePart>& parts)
    : mesh_(merged(parts)), trees_(std::make_unique<Trees>()) {
    std::vector<Vector3d> sharp;
    first_triangle_.push_back(0);
    for (const SculpturePart& part : parts) {
        trees_->parts.emplace_back(part.mesh);
        const auto points = sharp_edge_points(part.mesh);
        sharp.insert(sharp.end(), points.begin(), points.end());
        first_triangle_.push_back(first_triangle_.back() + part.mesh.triangles.size());
    }
    trees_->whole = std::make_unique<SurfaceTree>(mesh_);
    trees_->sharp = std::make_unique<PointTree>(sharp);
}

SculptureTruth::~SculptureTruth() = default;

SculptureTruth::Nearest SculptureTruth::nearest(const Vector3d& point) const {
    const auto hit = trees_->whole->nearest(point);
    const auto& corners = mesh_.triangles[hit->triangle];
    const auto& relief = mesh_.find_attribute("relief")->values;
    return {hit->point, triangle_normal(mesh_, hit->triangle).normalized(), hit->distance_mm,
            relief[corners[0]] > 0};
}

std::optional<double> SculptureTruth::error_along(const Vector3d& point, const Vector3d& direction,
                                                  double reach_mm) const {
    // The nearest crossing to the point on the line, either way.
    std::optional<double> best;
    for (double sign : {1.0, -1.0})
        if (const auto hit = trees_->whole->first_hit(point, sign * direction, 0, reach_mm))
            if (!best || hit->t < std::abs(*best)) best = -sign * hit->t;
    return best;
}

bool SculptureTruth::is_near_crease(const Vector3d& point, double distance_mm) const {
    if (trees_->sharp->nearest(point, distance_mm)) return true;
    // Lines where parts meet: near two parts' surfaces at once.
    int near = 0;
    for (const SurfaceTree& part : trees_->parts)
        if (part.nearest(point, distance_mm) && ++near == 2) return true;
    return false;
}

bool SculptureTruth::is_seen(const Vector3d& point, const Vector3d& normal,
                             const std::vector<TrueView>& views) const {
    constexpr double kCos70 = 0.3420201433256687;
    const auto free_to = [&](const Vector3d& from) {
        const Vector3d way = from - point;
        const double length = way.norm();
        if (normal.dot(way) < kCos70 * length) return false;
        // 0.01 mm: clear of the facet it lies on
        return !trees_->whole->first_hit(point + 0.01 * normal, way / length, 0, length);
    };
    for (const TrueView& view : views) {
        const Vector3d p = view.camera_from_object * point;
        if (std::abs(p.x()) > view.half_field_x * p.z() ||
            std::abs(p.y()) > view.half_field_y * p.z())
            continue;
        if (free_to(view.camera) && free_to(view.laser)) return true;
    }
    return false;
}

std::vector<SculptureTruth::Sample> SculptureTruth::samples(std::size_t count,
                                                            unsigned seed) const {
    std::vector<double> area_up_to;
    double area = 0;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
        area_up_to.push_back(area += 0.5 * triangle_normal(mesh_, t).norm());
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto& relief = mesh_.find_attribute("relief")->values;
    std::vector<Sample> chosen;
    for (std::size_t i = 0; i < count; ++i) {
        const double at = area * (static_cast<double>(i) + unit(rng)) / static_cast<double>(count);
        const auto t = static_cast<std::size_t>(
            std::upper_bound(area_up_to.begin(), area_up_to.end() - 1, at) - area_up_to.begin());
        double a = unit(rng), b = unit(rng);
        if (a + b > 1) {
            a = 1 - a;
            b = 1 - b;
        }
        const auto& c = mesh_.triangles[t];
        const Vector3d &p = mesh_.positions[c[0]], &q = mesh_.positions[c[1]],
                       &r = mesh_.positions[c[2]];
        chosen.push_back({p + a * (q - p) + b * (r - p), triangle_normal(mesh_, t).normalized(),
                          relief[c[0]] > 0});
    }
    return chosen;
}

Rigid3 fit_to_truth(const SculptureTruth& truth, const std::vector<Vector3d>& points,
                    const Rigid3& start, double gate_mm) {
    Rigid3 motion = start;
    const std::size_t stride = std::max<std::size_t>(1, points.size() / 20000);
    const std::size_t count = (points.size() + stride - 1) / stride;
    constexpr std::size_t kGrain = 512;
    struct Sums {
        Matrix6d jtj = Matrix6d::Zero();
        Vector6d jtr = Vector6d::Zero();
    };
    for (int round = 0; round < 12; ++round) {
        const double gate = std::max(0.25, gate_mm * std::pow(0.5, round));
        std::vector<Sums> parts((count + kGrain - 1) / kGrain);
        parallel_for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
            Sums& sums = parts[begin / kGrain];
            for (std::size_t i = begin; i < end; ++i) {
                const Vector3d p = motion * points[i * stride];
                const auto near = truth.nearest(p);
                if (near.distance_mm > gate) continue;
                Vector6d row;
                row << p.cross(near.normal), near.normal;
                sums.jtj += row * row.transpose();
                sums.jtr += row * near.normal.dot(near.point - p);
            }
        });
        Sums all;
        for (const Sums& part : parts) {
            all.jtj += part.jtj;
            all.jtr += part.jtr;
        }
        all.jtj += 1e-9 * Matrix6d::Identity();
        motion = rigid_from_vector(all.jtj.ldlt().solve(all.jtr)) * motion;
        motion.rotation = nearest_rotation(motion.rotation);
    }
    return motion;
}

}  // namespace stria

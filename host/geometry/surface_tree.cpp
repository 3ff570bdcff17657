#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "host/geometry/nearest.h"

namespace stria {
namespace {

using Eigen::Vector3d;

constexpr int kLeafSize = 4;
constexpr int kBins = 16;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Box {
    Vector3d low = Vector3d::Constant(kInfinity);
    Vector3d high = Vector3d::Constant(-kInfinity);

    void add(const Vector3d& point) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    void add(const Box& box) {
        low = low.cwiseMin(box.low);
        high = high.cwiseMax(box.high);
    }
    double half_area() const {
        const Vector3d d = (high - low).cwiseMax(0.0);
        return d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
    }
    double distance2(const Vector3d& point) const {
        return (low - point).cwiseMax(point - high).cwiseMax(0.0).squaredNorm();
    }
};

struct Node {
    Box box;
    std::uint32_t begin = 0;  ///< leaf: first triangle slot; inner: first of two children
    std::uint32_t count = 0;  ///< leaf: triangles; 0: inner
};

struct Corners {
    Vector3d a, b, c;
    std::uint32_t original;  ///< index in the mesh
};

/// Parameter in [0, 1] of the point of segment a-b nearest to p.
double nearest_on_segment(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
    const Vector3d ab = b - a;
    const double length2 = ab.squaredNorm();
    return length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
}

/// Barycentric coordinates of the point of a triangle's outline nearest to p.
Vector3d nearest_on_edges(const Corners& t, const Vector3d& p) {
    const std::array<const Vector3d*, 3> corner = {&t.a, &t.b, &t.c};
    double best2 = kInfinity;
    Vector3d best = Vector3d::UnitX();
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const double u = nearest_on_segment(*corner[static_cast<std::size_t>(i)],
                                            *corner[static_cast<std::size_t>(j)], p);
        Vector3d weights = Vector3d::Zero();
        weights[i] = 1.0 - u;
        weights[j] = u;
        const double d2 =
            (weights.x() * t.a + weights.y() * t.b + weights.z() * t.c - p).squaredNorm();
        if (d2 < best2) {
            best2 = d2;
            best = weights;
        }
    }
    return best;
}

/// Barycentric coordinates of the point of the triangle nearest to p: inside its prism the foot of
/// the perpendicular, else the nearest point of the outline. Degenerate triangles are outlines.
Vector3d nearest_on_triangle(const Corners& t, const Vector3d& p) {
    const Vector3d ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
    const Vector3d normal = ab.cross(ac);
    const double area2 = normal.squaredNorm();
    const double size2 = std::max(ab.squaredNorm(), ac.squaredNorm());
    if (area2 > 1e-28 * size2 * size2) {
        const double v = ap.cross(ac).dot(normal) / area2;
        const double w = ab.cross(ap).dot(normal) / area2;
        if (v >= 0 && w >= 0 && v + w <= 1) return {1.0 - v - w, v, w};
    }
    return nearest_on_edges(t, p);
}

/// A ray prepared for the watertight test of Woop, Benthin and Wald 2013: no ray slips through the
/// edge between two triangles.
struct ShearedRay {
    Vector3d origin, inverse;
    int kx, ky, kz;
    double sx, sy, sz;

    ShearedRay(const Vector3d& from, const Vector3d& direction) : origin(from) {
        direction.cwiseAbs().maxCoeff(&kz);
        kx = (kz + 1) % 3;
        ky = (kx + 1) % 3;
        if (direction[kz] < 0) std::swap(kx, ky);
        sx = direction[kx] / direction[kz];
        sy = direction[ky] / direction[kz];
        sz = 1.0 / direction[kz];
        for (int i = 0; i < 3; ++i)  // never 0 x infinity
            inverse[i] = std::abs(direction[i]) > 1e-290 ? 1.0 / direction[i]
                                                         : std::copysign(1e290, direction[i]);
    }

    /// Where the box is entered, at least t_min; infinity if missed before t_max.
    double enters(const Box& box, double t_min, double t_max) const {
        const Vector3d t0 = (box.low - origin).cwiseProduct(inverse);
        const Vector3d t1 = (box.high - origin).cwiseProduct(inverse);
        const double enter = std::max(t_min, t0.cwiseMin(t1).maxCoeff());
        const double leave = std::min(t_max, t0.cwiseMax(t1).minCoeff());
        const double slack = 1e-14 * std::max(std::abs(enter), std::abs(leave));
        return enter <= leave + slack ? enter : kInfinity;
    }

    std::optional<SurfaceTree::RayHit> hits(const Corners& triangle) const {
        const Vector3d a = triangle.a - origin, b = triangle.b - origin, c = triangle.c - origin;
        const double ax = a[kx] - sx * a[kz], ay = a[ky] - sy * a[kz];
        const double bx = b[kx] - sx * b[kz], by = b[ky] - sy * b[kz];
        const double cx = c[kx] - sx * c[kz], cy = c[ky] - sy * c[kz];
        const double u = cx * by - cy * bx;
        const double v = ax * cy - ay * cx;
        const double w = bx * ay - by * ax;
        if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return std::nullopt;
        const double sum = u + v + w;
        if (sum == 0) return std::nullopt;
        const Vector3d weights = Vector3d(u, v, w) / sum;
        const double t = sz * (weights.x() * a[kz] + weights.y() * b[kz] + weights.z() * c[kz]);
        return SurfaceTree::RayHit{triangle.original, t, weights};
    }
};

}  // namespace

struct SurfaceTree::Tree {
    std::vector<Node> nodes;
    std::vector<Corners> triangles;

    explicit Tree(const TriMesh& mesh);
    void build(std::uint32_t node, std::uint32_t begin, std::uint32_t end,
               std::vector<std::uint32_t>& order, const std::vector<Box>& boxes);
};

SurfaceTree::Tree::Tree(const TriMesh& mesh) {
    std::vector<Corners> all;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const auto& corner = mesh.triangles[i];
        for (std::uint32_t vertex : corner)
            if (vertex >= mesh.positions.size())
                throw std::invalid_argument("SurfaceTree: triangle " + std::to_string(i) +
                                            " refers to vertex " + std::to_string(vertex) + " of " +
                                            std::to_string(mesh.positions.size()));
        const Corners t = {mesh.positions[corner[0]], mesh.positions[corner[1]],
                           mesh.positions[corner[2]], static_cast<std::uint32_t>(i)};
        if (t.a.allFinite() && t.b.allFinite() && t.c.allFinite()) all.push_back(t);
    }
    if (all.empty()) return;
    std::vector<Box> boxes(all.size());
    std::vector<std::uint32_t> order(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        boxes[i].add(all[i].a);
        boxes[i].add(all[i].b);
        boxes[i].add(all[i].c);
        order[i] = static_cast<std::uint32_t>(i);
    }
    nodes.reserve(all.size());
    nodes.emplace_back();
    build(0, 0, static_cast<std::uint32_t>(all.size()), order, boxes);
    triangles.reserve(all.size());
    for (std::uint32_t index : order) triangles.push_back(all[index]);
}

/// Binned surface area heuristic (Wald 2007), halves by count where it finds no split.
void SurfaceTree::Tree::build(std::uint32_t node, std::uint32_t begin, std::uint32_t end,
                              std::vector<std::uint32_t>& order, const std::vector<Box>& boxes) {
    Box box, centres;
    const auto centre = [&](std::uint32_t i) -> Vector3d {
        return 0.5 * (boxes[i].low + boxes[i].high);
    };
    for (std::uint32_t i = begin; i < end; ++i) {
        box.add(boxes[order[i]]);
        centres.add(centre(order[i]));
    }
    nodes[node] = {.box = box, .begin = begin, .count = end - begin};
    if (end - begin <= kLeafSize) return;

    int axis = 0;
    const double extent = (centres.high - centres.low).maxCoeff(&axis);
    std::uint32_t middle = begin + (end - begin) / 2;
    const auto first = order.begin();
    if (extent > 0) {
        const double scale = kBins / extent;
        const auto bin_of = [&](std::uint32_t i) {
            const double at = (centre(i)[axis] - centres.low[axis]) * scale;
            return std::clamp(static_cast<int>(at), 0, kBins - 1);
        };
        std::array<Box, kBins> bin_box;
        std::array<std::uint32_t, kBins> bin_count{};
        for (std::uint32_t i = begin; i < end; ++i) {
            const auto bin = static_cast<std::size_t>(bin_of(order[i]));
            bin_box[bin].add(boxes[order[i]]);
            ++bin_count[bin];
        }
        std::array<double, kBins> right_cost{};
        Box right;
        std::uint32_t right_count = 0;
        for (std::size_t i = kBins - 1; i > 0; --i) {
            right.add(bin_box[i]);
            right_count += bin_count[i];
            right_cost[i] = right_count == 0 ? 0 : right.half_area() * right_count;
        }
        Box left;
        std::uint32_t left_count = 0;
        double best = kInfinity;
        int best_bin = -1;
        for (std::size_t i = 0; i + 1 < kBins; ++i) {
            left.add(bin_box[i]);
            left_count += bin_count[i];
            if (left_count == 0 || left_count == end - begin) continue;
            const double cost = left.half_area() * left_count + right_cost[i + 1];
            if (cost < best) {
                best = cost;
                best_bin = static_cast<int>(i);
            }
        }
        if (best_bin >= 0) {
            const auto split = std::stable_partition(
                first + begin, first + end, [&](std::uint32_t i) { return bin_of(i) <= best_bin; });
            middle = static_cast<std::uint32_t>(split - first);
        }
    }
    const auto child = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    nodes.emplace_back();
    nodes[node].begin = child;
    nodes[node].count = 0;
    build(child, begin, middle, order, boxes);
    build(child + 1, middle, end, order, boxes);
}

SurfaceTree::SurfaceTree(const TriMesh& mesh) : tree_(std::make_unique<Tree>(mesh)) {}
SurfaceTree::~SurfaceTree() = default;
SurfaceTree::SurfaceTree(SurfaceTree&&) noexcept = default;
SurfaceTree& SurfaceTree::operator=(SurfaceTree&&) noexcept = default;

std::optional<SurfaceTree::Hit> SurfaceTree::nearest(const Vector3d& query,
                                                     double max_distance_mm) const {
    if (tree_->nodes.empty() || !query.allFinite() || !(max_distance_mm >= 0)) return std::nullopt;
    double best2 = max_distance_mm * max_distance_mm;  // infinite for the default: fine
    std::optional<Hit> best;
    const auto descend = [&](const auto& self, std::uint32_t index) -> void {
        const Node& node = tree_->nodes[index];
        if (node.count > 0) {
            for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) {
                const Corners& t = tree_->triangles[i];
                const Vector3d weights = nearest_on_triangle(t, query);
                const Vector3d point = weights.x() * t.a + weights.y() * t.b + weights.z() * t.c;
                const double d2 = (point - query).squaredNorm();
                if (d2 > best2 || (best && d2 == best2 && t.original > best->triangle)) continue;
                best2 = d2;
                best = Hit{t.original, point, weights, 0.0};
            }
            return;
        }
        const double d0 = tree_->nodes[node.begin].box.distance2(query);
        const double d1 = tree_->nodes[node.begin + 1].box.distance2(query);
        const std::uint32_t near = d0 <= d1 ? 0 : 1;
        const std::uint32_t begin = node.begin;
        if (std::min(d0, d1) <= best2) self(self, begin + near);
        if (std::max(d0, d1) <= best2) self(self, begin + 1 - near);
    };
    descend(descend, 0);
    if (best) best->distance_mm = std::sqrt(best2);
    return best;
}

std::optional<SurfaceTree::RayHit> SurfaceTree::first_hit(const Vector3d& origin,
                                                          const Vector3d& direction, double t_min,
                                                          double t_max) const {
    if (tree_->nodes.empty() || !origin.allFinite() || !direction.allFinite() ||
        direction.isZero(0.0))
        return std::nullopt;
    const ShearedRay ray(origin, direction);
    std::optional<RayHit> best;
    double limit = t_max;
    const auto descend = [&](const auto& self, std::uint32_t index) -> void {
        const Node& node = tree_->nodes[index];
        if (node.count > 0) {
            for (std::uint32_t i = node.begin; i < node.begin + node.count; ++i) {
                const auto hit = ray.hits(tree_->triangles[i]);
                if (!hit || hit->t < t_min || hit->t > limit) continue;
                if (best && hit->t == limit && hit->triangle > best->triangle) continue;
                best = hit;
                limit = hit->t;
            }
            return;
        }
        const std::uint32_t begin = node.begin;
        const double e0 = ray.enters(tree_->nodes[begin].box, t_min, limit);
        const double e1 = ray.enters(tree_->nodes[begin + 1].box, t_min, limit);
        const std::uint32_t near = e0 <= e1 ? 0 : 1;
        if (std::min(e0, e1) < kInfinity) self(self, begin + near);
        const double far = std::max(e0, e1);
        if (far < kInfinity && far <= limit) self(self, begin + 1 - near);
    };
    descend(descend, 0);
    return best;
}

}  // namespace stria

#include "host/registration/scan_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "firmware/core/median.h"
#include "host/geometry/range_grid.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

/// A copy without the points that are not finite; empty if there are none.
std::optional<RangeImage> without_broken_points(const RangeImage& image) {
    std::optional<RangeImage> clean;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell)
        if (image.mask[cell] && !image.points[cell].position.allFinite()) {
            if (!clean) clean = image;
            clean->mask[cell] = 0;
        }
    return clean;
}

/// Area-weighted normals of the cells, not unit, zero where there is no triangle.
std::vector<Vector3d> cell_normals(const RangeImage& image, const Triangles& triangles) {
    std::vector<Vector3d> sums(image.cell_count(), Vector3d::Zero());
    for (const auto& t : triangles) {
        const Vector3d& a = image.points[t[0]].position;
        const Vector3d area =
            (image.points[t[1]].position - a).cross(image.points[t[2]].position - a);
        for (const std::uint32_t cell : t) sums[cell] += area;
    }
    for (Vector3d& sum : sums) sum.normalize();
    return sums;
}

/// Each normal averaged with those of its eight neighbours that bend less than 30 degrees away and
/// are joined to it.
std::vector<Vector3d> smoothed(const RangeImage& image, const std::vector<Vector3d>& normals,
                               double max_edge_mm) {
    constexpr double kCosMaxBend = 0.866;
    std::vector<Vector3d> result(normals.size(), Vector3d::Zero());
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const std::size_t cell = image.cell(x, y);
            if (normals[cell].isZero(0.0)) continue;
            Vector3d sum = Vector3d::Zero();
            for (int v = std::max(0, y - 1); v <= std::min(image.height - 1, y + 1); ++v)
                for (int u = std::max(0, x - 1); u <= std::min(image.width - 1, x + 1); ++u) {
                    const std::size_t other = image.cell(u, v);
                    if (normals[other].dot(normals[cell]) < kCosMaxBend) continue;
                    const Vector3d step =
                        image.points[other].position - image.points[cell].position;
                    if (step.norm() <= max_edge_mm) sum += normals[other];
                }
            result[cell] = sum.normalized();
        }
    return result;
}

/// The inner points in an order of which any first part is spread evenly: multiples of the golden
/// ratio, modulo the count, never crowd.
std::vector<std::uint32_t> nested_samples(const std::vector<std::uint32_t>& inner) {
    const std::size_t count = inner.size();
    std::vector<std::uint32_t> order;
    std::vector<std::uint8_t> taken(count, 0);
    order.reserve(count);
    double at = 0.5;
    for (std::size_t k = 0; k < count; ++k) {
        at += 1.0 / std::numbers::phi;
        at -= std::floor(at);
        auto slot = static_cast<std::size_t>(at * static_cast<double>(count));
        if (slot >= count || taken[slot]) continue;  // the few left out come last
        taken[slot] = 1;
        order.push_back(inner[slot]);
    }
    for (std::size_t slot = 0; slot < count; ++slot)
        if (!taken[slot]) order.push_back(inner[slot]);
    return order;
}

bool has_sigma(const RangeImage& image) {
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell)
        if (image.mask[cell] && !(image.points[cell].sigma_mm > 0)) return false;
    return true;
}

/// Raises each sigma to a third of the median, so that no point rules by claiming to be perfect.
void limit_from_below(std::vector<double>& sigmas) {
    const double least = median(sigmas) / 3;
    for (double& sigma : sigmas) sigma = std::max(sigma, least);
}

/// Standard deviation along `normal` of a point with sigma along its error direction and across it.
double sigma_along(const RangePoint& point, const Vector3d& normal) {
    const double cosine = normal.dot(point.error_direction.cast<double>());
    const double along = point.sigma_mm * cosine;
    const double across2 = std::pow(point.sigma_across_mm, 2) * std::max(0.0, 1 - cosine * cosine);
    return std::sqrt(along * along + across2);
}

bool touches_rim(const RangeImage& image) {
    for (int x = 0; x < image.width; ++x)
        if (image.has(x, 0) || image.has(x, image.height - 1)) return true;
    for (int y = 0; y < image.height; ++y)
        if (image.has(0, y) || image.has(image.width - 1, y)) return true;
    return false;
}

void fill_bounds(ScanSurface& surface) {
    if (surface.points.empty()) return;
    surface.low = surface.high = surface.points.front();
    Vector3d sum = Vector3d::Zero();
    for (const Vector3d& point : surface.points) {
        surface.low = surface.low.cwiseMin(point);
        surface.high = surface.high.cwiseMax(point);
        sum += point;
    }
    surface.centre = sum / static_cast<double>(surface.points.size());
}

ScanSurface prepare_finite(const RangeImage& image, const ScanSurfaceOptions& options) {
    ScanSurface surface;
    surface.pitch_mm = median_pitch_mm(image);
    surface.stations = image.stations;
    surface.is_whole = !touches_rim(image);
    if (!(surface.pitch_mm > 0)) return surface;
    const double max_edge = options.max_edge_mm > 0 ? options.max_edge_mm : 4 * surface.pitch_mm;
    const Triangles triangles = range_triangles(image, {.max_edge_mm = max_edge});
    const auto border = border_distance(image, triangles, options.border_cells + 1);
    std::vector<Vector3d> normals = cell_normals(image, triangles);
    for (int round = 0; round < options.normal_rounds; ++round)
        normals = smoothed(image, normals, max_edge);

    const bool with_sigma = has_sigma(image);
    std::vector<std::uint32_t> inner;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell) {
        if (!image.mask[cell] || normals[cell].isZero(0.0)) continue;
        const RangePoint& point = image.points[cell];
        if (border[cell] >= options.border_cells)
            inner.push_back(static_cast<std::uint32_t>(surface.points.size()));
        surface.points.push_back(point.position);
        surface.normals.push_back(normals[cell]);
        surface.to_camera.push_back(direction_to_camera(image, point));
        surface.is_border.push_back(border[cell] == 0);
        if (with_sigma) surface.sigma_mm.push_back(sigma_along(point, normals[cell]));
    }
    limit_from_below(surface.sigma_mm);
    surface.samples = nested_samples(inner);
    fill_bounds(surface);
    surface.tree = PointTree(surface.points);
    surface.occupancy = OccupancyGrid(surface.points, 3 * surface.pitch_mm);
    return surface;
}

}  // namespace

SurfaceList list_of(const std::vector<ScanSurface>& surfaces) {
    SurfaceList list;
    for (const ScanSurface& surface : surfaces) list.push_back(&surface);
    return list;
}

ScanSurface prepare_surface(const RangeImage& image, const ScanSurfaceOptions& options) {
    const std::optional<RangeImage> clean = without_broken_points(image);
    return prepare_finite(clean ? *clean : image, options);
}

}  // namespace stria

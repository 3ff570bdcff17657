#include "host/fusion/range_surface.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "firmware/core/median.h"
#include "firmware/core/pulse.h"
#include "host/geometry/range_grid.h"

namespace stria {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr std::uint16_t kDoubtful =
    kPulseSpatialFallback | kPulseOverlapping | kPulseGhostSuspected;

/// Cells whose pulse was the only one and is trusted.
std::vector<std::uint8_t> carving_cells(const RangeImage& image) {
    std::vector<std::uint8_t> carves(image.cell_count(), 0);
    for (std::size_t cell = 0; cell < carves.size(); ++cell)
        carves[cell] = image.mask[cell] && !(image.points[cell].flags & kDoubtful);
    for (const FurtherReturn& other : image.further)
        if (other.cell < carves.size()) carves[other.cell] = 0;
    return carves;
}

/// Unit normals of the cells: the image's own, else those of its triangles.
std::vector<Eigen::Vector3f> cell_normals(const RangeImage& image, const Triangles& triangles) {
    RangeImage copy;
    copy.width = image.width;
    copy.height = image.height;
    copy.mask = image.mask;
    copy.points = image.points;
    compute_normals(copy, triangles);
    std::vector<Eigen::Vector3f> normals(image.cell_count(), Eigen::Vector3f::Zero());
    for (std::size_t cell = 0; cell < normals.size(); ++cell) {
        const Eigen::Vector3f& own = image.points[cell].normal;
        normals[cell] = own.squaredNorm() > 0.5f ? own : copy.points[cell].normal;
    }
    return normals;
}

float vertex_weight(const RangeImage& image, const RangePoint& point, const Eigen::Vector3f& normal,
                    int border_cells, const RangeSurfaceOptions& options) {
    const double cosine =
        std::max(0.0, normal.cast<double>().dot(direction_to_camera(image, point)));
    double weight = cosine * cosine;
    if (options.border_taper_cells > 0)
        weight *= std::min(1.0, (1.0 + border_cells) / (1.0 + options.border_taper_cells));
    if (options.reference_sigma_mm > 0 && point.sigma_mm > 0) {
        const double ratio = options.reference_sigma_mm / point.sigma_mm;
        weight *= std::clamp(ratio * ratio, 1.0 / 64, 1.0);
    }
    return static_cast<float>(weight);
}

bool stations_move(const RangeImage& image, Eigen::Vector3d Station::*where) {
    return std::any_of(image.stations.begin(), image.stations.end(), [&](const Station& station) {
        return (station.*where - image.stations.front().*where).norm() > 1e-6;
    });
}

SurfaceVertex make_vertex(const RangeImage& image, const RangePoint& point, const Rigid3& pose) {
    SurfaceVertex vertex;
    vertex.position = pose * point.position;
    if (!image.stations.empty()) {
        const Station station = station_at(image, point.s);
        vertex.camera = pose * station.camera_in_scan;
        vertex.laser = pose * station.laser_in_scan;
    }
    vertex.s = point.s;
    vertex.sigma_mm = point.sigma_mm;
    vertex.systematic_mm = point.sigma_systematic_mm;
    return vertex;
}

/// Appends the triangles of neighbouring cells that are not in the (ascending) list yet.
void append_gaps(const RangeImage& image, Triangles& triangles) {
    const Triangles all = range_triangles(image, {.max_edge_mm = 1e9, .max_incidence_rad = 1.5707});
    const std::set<std::array<std::uint32_t, 3>> known(triangles.begin(), triangles.end());
    for (const auto& t : all)
        if (!known.count(t)) triangles.push_back(t);
}

}  // namespace

double median_sigma_mm(const RangeImage& image) {
    std::vector<float> sigmas;
    for (std::size_t cell = 0; cell < image.cell_count(); ++cell)
        if (image.mask[cell] && image.points[cell].sigma_mm > 0)
            sigmas.push_back(image.points[cell].sigma_mm);
    return median(std::move(sigmas));
}

RangeSurface make_range_surface(const RangeImage& image, const Rigid3& world_from_scan,
                                const RangeSurfaceOptions& options) {
    RangeSurface surface;
    surface.orthographic = image.stations.empty();
    surface.camera_moves = stations_move(image, &Station::camera_in_scan);
    surface.laser_moves = stations_move(image, &Station::laser_in_scan);
    surface.towards_camera = world_from_scan.rotation * Eigen::Vector3d::UnitZ();
    surface.median_sigma_mm = median_sigma_mm(image);

    Triangles triangles = range_triangles(image, {.max_edge_mm = options.max_edge_mm,
                                                  .max_incidence_rad = options.max_incidence_rad});
    const auto border = border_distance(image, triangles, options.border_taper_cells);
    const auto normals = cell_normals(image, triangles);
    const auto carves = carving_cells(image);

    surface.first_gap = triangles.size();
    if (options.with_gaps) append_gaps(image, triangles);

    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::vector<std::uint32_t> vertex_of(image.cell_count(), kNone);
    for (const auto& t : triangles)
        for (const std::uint32_t cell : t) vertex_of[cell] = 0;
    for (std::uint32_t cell = 0; cell < vertex_of.size(); ++cell) {
        if (vertex_of[cell] == kNone) continue;
        vertex_of[cell] = static_cast<std::uint32_t>(surface.vertices.size());
        const RangePoint& point = image.points[cell];
        SurfaceVertex vertex = make_vertex(image, point, world_from_scan);
        vertex.weight = vertex_weight(image, point, normals[cell], border[cell], options);
        vertex.carves = carves[cell] != 0;
        surface.vertices.push_back(vertex);
        surface.cells.push_back(cell);
    }
    for (auto& t : triangles)
        for (std::uint32_t& corner : t) corner = vertex_of[corner];
    surface.triangles = std::move(triangles);
    return surface;
}

}  // namespace stria

#include "host/geometry/range_grid.h"
#include "firmware/core/median.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace stria {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Triangles = std::vector<Triangle>;

double squared_distance(const RangeImage& image, std::uint32_t a, std::uint32_t b) {
    return (image.points[a].position - image.points[b].position).squaredNorm();
}

/// Cuts quads into triangles, all wound the same way round the grid.
class QuadCutter {
  public:
    QuadCutter(const RangeImage& image, double max_edge_mm)
        : image_(image), max_squared_(max_edge_mm * max_edge_mm) {}

    void cut(int x, int y, Triangles& out) const {
        const auto c00 = static_cast<std::uint32_t>(image_.cell(x, y));
        const std::uint32_t c10 = c00 + 1;
        const std::uint32_t c01 = c00 + static_cast<std::uint32_t>(image_.width);
        const std::uint32_t c11 = c01 + 1;
        const auto& m = image_.mask;
        const bool main_diagonal = m[c00] && m[c11];
        const bool other_diagonal = m[c10] && m[c01];
        if (!main_diagonal && !other_diagonal) return;
        const bool use_main =
            main_diagonal && (!other_diagonal || squared_distance(image_, c00, c11) <=
                                                     squared_distance(image_, c10, c01));
        if (use_main) {
            if (m[c10]) add({c00, c10, c11}, out);
            if (m[c01]) add({c00, c11, c01}, out);
        } else {
            if (m[c00]) add({c00, c10, c01}, out);
            if (m[c11]) add({c10, c11, c01}, out);
        }
    }

  private:
    void add(const Triangle& t, Triangles& out) const {
        for (int k = 0; k < 3; ++k)
            if (!(squared_distance(image_, t[static_cast<std::size_t>(k)],
                                   t[static_cast<std::size_t>((k + 1) % 3)]) <= max_squared_))
                return;
        out.push_back(t);
    }

    const RangeImage& image_;
    double max_squared_;
};

/// Cosine between the triangle's normal and the direction to the camera; 0 if degenerate.
double facing(const RangeImage& image, const Triangle& t) {
    const RangePoint& a = image.points[t[0]];
    const RangePoint& b = image.points[t[1]];
    const RangePoint& c = image.points[t[2]];
    const Eigen::Vector3d normal = (b.position - a.position).cross(c.position - a.position);
    const double length = normal.norm();
    if (!(length > 0)) return 0;
    RangePoint centre;
    centre.position = (a.position + b.position + c.position) / 3;
    centre.s = (a.s + b.s + c.s) / 3;
    return normal.dot(direction_to_camera(image, centre)) / length;
}

/// Number (0..3) of the edge between two neighbouring cells, kept at the lower one, `home`: towards
/// right, below, below right, below left.
std::uint32_t edge_slot(std::uint32_t a, std::uint32_t b, std::uint32_t width,
                        std::uint32_t& home) {
    if (a > b) std::swap(a, b);
    home = a;
    if (a / width == b / width) return 0;
    const std::uint32_t xa = a % width, xb = b % width;
    return xb == xa ? 1 : xb > xa ? 2 : 3;
}

/// How many triangles use each edge: four counters a cell.
std::vector<std::uint8_t> edge_uses(const RangeImage& image, const Triangles& triangles) {
    const auto width = static_cast<std::uint32_t>(image.width);
    std::vector<std::uint8_t> uses(image.cell_count() * 4, 0);
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            std::uint32_t home = 0;
            const std::uint32_t slot = edge_slot(t[k], t[(k + 1) % 3], width, home);
            ++uses[home * 4 + slot];
        }
    return uses;
}

std::uint32_t other_end(std::uint32_t home, std::size_t slot, std::uint32_t width) {
    const std::uint32_t steps[4] = {1, width, width + 1, width - 1};
    return home + steps[slot];
}

}  // namespace

std::vector<Triangle> range_triangles(const RangeImage& image, const RangeGridOptions& options) {
    const double max_edge =
        options.max_edge_mm > 0 ? options.max_edge_mm : 4 * median_pitch_mm(image);
    const QuadCutter cutter(image, max_edge);
    Triangles all;
    for (int y = 0; y + 1 < image.height; ++y)
        for (int x = 0; x + 1 < image.width; ++x) cutter.cut(x, y, all);

    // Seen from the camera one way round the grid is counter-clockwise; most triangles know which.
    std::vector<double> cosines(all.size());
    std::size_t forwards = 0, backwards = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        cosines[i] = facing(image, all[i]);
        forwards += cosines[i] > 0;
        backwards += cosines[i] < 0;
    }
    const bool flip = backwards > forwards;
    const double min_cosine = std::cos(options.max_incidence_rad);
    Triangles kept;
    kept.reserve(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        if ((flip ? -cosines[i] : cosines[i]) < min_cosine) continue;
        if (flip) std::swap(all[i][1], all[i][2]);
        kept.push_back(all[i]);
    }
    return kept;
}

double median_pitch_mm(const RangeImage& image) {
    std::vector<double> pitches;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            if (!image.has(x, y)) continue;
            const Eigen::Vector3d& here = image.at(x, y).position;
            if (x + 1 < image.width && image.has(x + 1, y))
                pitches.push_back((image.at(x + 1, y).position - here).norm());
            if (y + 1 < image.height && image.has(x, y + 1))
                pitches.push_back((image.at(x, y + 1).position - here).norm());
        }
    return median(std::move(pitches));
}

std::vector<std::uint16_t> border_distance(const RangeImage& image,
                                           const std::vector<Triangle>& triangles, int cap) {
    const auto width = static_cast<std::uint32_t>(image.width);
    const auto limit = static_cast<std::uint16_t>(std::clamp(cap, 0, 65535));
    const std::vector<std::uint8_t> uses = edge_uses(image, triangles);
    std::vector<std::uint16_t> distance(image.cell_count(), limit);
    std::vector<std::uint8_t> in_triangle(image.cell_count(), 0);
    for (const Triangle& t : triangles)
        for (const std::uint32_t cell : t) in_triangle[cell] = 1;
    for (std::uint32_t cell = 0; cell < distance.size(); ++cell) {
        if (!in_triangle[cell]) distance[cell] = 0;
        for (std::size_t slot = 0; slot < 4; ++slot)
            if (uses[cell * 4 + slot] == 1)
                distance[cell] = distance[other_end(cell, slot, width)] = 0;
    }

    std::vector<std::uint32_t> front, next;
    for (std::uint32_t cell = 0; cell < distance.size(); ++cell)
        if (in_triangle[cell] && distance[cell] == 0) front.push_back(cell);
    for (std::uint16_t d = 1; d < limit && !front.empty(); ++d) {
        next.clear();
        const auto visit = [&](std::uint32_t cell) {
            if (distance[cell] <= d) return;
            distance[cell] = d;
            next.push_back(cell);
        };
        for (const std::uint32_t cell : front)
            for (std::size_t slot = 0; slot < 4; ++slot) {
                if (uses[cell * 4 + slot]) visit(other_end(cell, slot, width));
                const std::uint32_t step = other_end(0, slot, width);
                if (cell >= step && uses[(cell - step) * 4 + slot]) visit(cell - step);
            }
        front.swap(next);
    }
    return distance;
}

void compute_normals(RangeImage& image, const std::vector<Triangle>& triangles) {
    std::vector<Eigen::Vector3d> sums(image.cell_count(), Eigen::Vector3d::Zero());
    for (const Triangle& t : triangles) {
        const Eigen::Vector3d& a = image.points[t[0]].position;
        const Eigen::Vector3d area =
            (image.points[t[1]].position - a).cross(image.points[t[2]].position - a);  // twice
        for (const std::uint32_t cell : t) sums[cell] += area;
    }
    for (std::size_t cell = 0; cell < sums.size(); ++cell) {
        const double length = sums[cell].norm();
        image.points[cell].normal = length > 0
                                        ? Eigen::Vector3f((sums[cell] / length).cast<float>())
                                        : Eigen::Vector3f::Zero();
    }
}

}  // namespace stria

#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "host/core/range_image.h"

namespace stria {

struct RangeGridOptions {
    double max_edge_mm = 0;           ///< longer edges are not surface; 0: 4 x the median pitch
    double max_incidence_rad = 1.48;  ///< triangles seen flatter than this are not surface (85 deg)
};

/// Triangles of a range image, as cell numbers, counter-clockwise seen from the camera. Of the two
/// diagonals of a full quad the shorter; three present corners give one triangle.
std::vector<std::array<std::uint32_t, 3>> range_triangles(const RangeImage& image,
                                                          const RangeGridOptions& options = {});

/// Median distance of horizontally and vertically neighbouring points, mm; 0 with no neighbours.
double median_pitch_mm(const RangeImage& image);

/// Distance in cells (8-neighbour steps along triangle edges) from each point to the nearest border
/// of the triangulated surface; 0 on the border and for points in no triangle; capped at `cap`.
std::vector<std::uint16_t> border_distance(
    const RangeImage& image, const std::vector<std::array<std::uint32_t, 3>>& triangles,
    int cap = 32);

/// Writes every point's normal (unit, towards the camera) as the area-weighted mean of its
/// triangles; zero where it has none.
void compute_normals(RangeImage& image, const std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace stria

#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "host/fusion/range_surface.h"

namespace stria {

/// Quads (four points in the world, on a screen behind the camera's lines of sight) that cover the
/// cells without return, each between four empty cells: runs of up to 16 cells of a row. Where an
/// empty cell looks is found by a polynomial map from cell to direction, fitted to the cells with
/// points: of degree 1, or 3 where that leaves more than a fifth of a cell. Throws stria::Error if
/// the camera moves: then an empty cell has no line of sight of its own.
std::vector<std::array<Eigen::Vector3d, 4>> background_quads(const RangeImage& image,
                                                             const RangeSurface& surface);

}  // namespace stria

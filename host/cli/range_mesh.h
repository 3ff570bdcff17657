#pragma once
#include "host/core/range_image.h"
#include "host/core/tri_mesh.h"

namespace stria {

/// The points of a range image with their attributes: "normal" (where any is known), "intensity",
/// "sigma", "sigma_across", "sigma_systematic" (mm), in the order of the cells, further returns
/// left out.
PointCloud range_points(const RangeImage& image);

/// The same points with the triangles of the grid between them (range_triangles).
TriMesh range_mesh(const RangeImage& image);

}  // namespace stria

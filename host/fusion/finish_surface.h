#pragma once
#include "host/core/tri_mesh.h"

namespace stria {

/// Removes components (triangles joined by vertices) whose measured area, that of triangles
/// without a filled vertex, is less than min_area_mm2, and vertices that no triangle uses. Order is
/// kept. Needs the attribute "filled".
void drop_small_components(TriMesh& mesh, double min_area_mm2);

/// Moves every filled vertex half-way to the mean of its neighbours, `rounds` times; measured
/// vertices stay. All vertices move at once, so the result does not depend on their order.
void smooth_filled(TriMesh& mesh, int rounds);

/// Attribute "normal": unit, area-weighted mean of the triangles at each vertex.
void add_normals(TriMesh& mesh);

}  // namespace stria

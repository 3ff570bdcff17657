#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/core/tri_mesh.h"

namespace stria {

/// Size and topology of a mesh, by vertex number: vertices at one place count as different.
struct MeshInfo {
    std::size_t vertices = 0;
    std::size_t referenced_vertices = 0;  ///< used by a triangle
    std::size_t triangles = 0;
    std::size_t components = 0;          ///< of triangles that share vertices
    std::size_t boundary_edges = 0;      ///< with one triangle
    std::size_t non_manifold_edges = 0;  ///< with more than two
    std::ptrdiff_t euler = 0;            ///< V - E + F over referenced vertices
    double area_mm2 = 0;
    double volume_mm3 = 0;  ///< signed sum of tetrahedra to the origin's side; meaningful if closed
    bool closed = false;    ///< triangles, no boundary and no non-manifold edge
    std::size_t degenerate_triangles = 0;  ///< a vertex twice, or no area
};

MeshInfo mesh_info(const TriMesh& mesh);

/// Component of each triangle: 0, 1, ... in order of their first triangles. Two triangles belong
/// together if a chain of triangles with common vertices joins them.
std::vector<std::uint32_t> triangle_components(const TriMesh& mesh);

}  // namespace stria

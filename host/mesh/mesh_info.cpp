#include "host/mesh/mesh_info.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace stria {
namespace {

class DisjointSets {
  public:
    explicit DisjointSets(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    std::uint32_t find(std::uint32_t v) {
        while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
        return v;
    }
    void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

  private:
    std::vector<std::uint32_t> parent_;
};

/// Every side of every triangle as a number, the lower vertex first, sorted.
std::vector<std::uint64_t> sorted_sides(const TriMesh& mesh) {
    std::vector<std::uint64_t> sides;
    sides.reserve(mesh.triangles.size() * 3);
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
            if (low != high) sides.push_back(std::uint64_t{low} << 32 | high);
        }
    std::sort(sides.begin(), sides.end());
    return sides;
}

/// Counts edges by their number of triangles; returns how many there are.
std::size_t count_edges(const TriMesh& mesh, MeshInfo& info) {
    const std::vector<std::uint64_t> sides = sorted_sides(mesh);
    std::size_t edges = 0;
    for (std::size_t i = 0; i < sides.size(); ++edges) {
        std::size_t end = i + 1;
        while (end < sides.size() && sides[end] == sides[i]) ++end;
        info.boundary_edges += end - i == 1;
        info.non_manifold_edges += end - i > 2;
        i = end;
    }
    return edges;
}

void measure(const TriMesh& mesh, MeshInfo& info) {
    if (mesh.positions.empty()) return;
    // About a point of the mesh: far from the origin the sum would lose digits.
    const Eigen::Vector3d& centre = mesh.positions.front();
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3d a = mesh.positions[t[0]] - centre;
        const Eigen::Vector3d b = mesh.positions[t[1]] - centre;
        const Eigen::Vector3d c = mesh.positions[t[2]] - centre;
        const double area = 0.5 * (b - a).cross(c - a).norm();
        info.area_mm2 += area;
        info.volume_mm3 += a.dot(b.cross(c)) / 6;
        info.degenerate_triangles += !(area > 0) || t[0] == t[1] || t[1] == t[2] || t[0] == t[2];
    }
}

}  // namespace

std::vector<std::uint32_t> triangle_components(const TriMesh& mesh) {
    DisjointSets sets(mesh.positions.size());
    for (const auto& t : mesh.triangles) {
        sets.join(t[0], t[1]);
        sets.join(t[0], t[2]);
    }
    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::vector<std::uint32_t> number(mesh.positions.size(), kNone), component;
    component.reserve(mesh.triangles.size());
    std::uint32_t next = 0;
    for (const auto& t : mesh.triangles) {
        std::uint32_t& of_root = number[sets.find(t[0])];
        if (of_root == kNone) of_root = next++;
        component.push_back(of_root);
    }
    return component;
}

MeshInfo mesh_info(const TriMesh& mesh) {
    MeshInfo info;
    info.vertices = mesh.positions.size();
    info.triangles = mesh.triangles.size();
    std::vector<std::uint8_t> used(mesh.positions.size(), 0);
    for (const auto& t : mesh.triangles)
        for (const std::uint32_t v : t) used[v] = 1;
    info.referenced_vertices = static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
    const std::size_t edges = count_edges(mesh, info);
    info.euler = static_cast<std::ptrdiff_t>(info.referenced_vertices + info.triangles) -
                 static_cast<std::ptrdiff_t>(edges);
    for (const std::uint32_t c : triangle_components(mesh))
        info.components = std::max<std::size_t>(info.components, c + 1);
    measure(mesh, info);
    info.closed = info.triangles > 0 && info.boundary_edges == 0 && info.non_manifold_edges == 0;
    return info;
}

}  // namespace stria

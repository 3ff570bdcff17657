#include "host/fusion/finish_surface.h"

#include <Eigen/Geometry>
#include <cstddef>
#include <numeric>

namespace stria {
namespace {

/// Disjoint sets of vertices, halving paths.
class Components {
  public:
    explicit Components(std::size_t count) : parent_(count) {
        std::iota(parent_.begin(), parent_.end(), 0u);
    }
    std::uint32_t find(std::uint32_t v) {
        while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
        return v;
    }
    void join(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        if (a < b) parent_[b] = a;
        if (b < a) parent_[a] = b;
    }

  private:
    std::vector<std::uint32_t> parent_;
};

Eigen::Vector3d area_vector(const TriMesh& mesh, const std::array<std::uint32_t, 3>& t) {
    const Eigen::Vector3d& a = mesh.positions[t[0]];
    return 0.5 * (mesh.positions[t[1]] - a).cross(mesh.positions[t[2]] - a);
}

/// Keeps the vertices with keep != 0 and renumbers.
void compact(TriMesh& mesh, const std::vector<std::uint8_t>& keep) {
    std::vector<std::uint32_t> number(keep.size(), 0);
    std::uint32_t count = 0;
    for (std::size_t v = 0; v < keep.size(); ++v) {
        if (!keep[v]) continue;
        number[v] = count;
        mesh.positions[count] = mesh.positions[v];
        for (VertexAttribute& attribute : mesh.attributes) {
            const auto n = static_cast<std::size_t>(attribute.components);
            for (std::size_t c = 0; c < n; ++c)
                attribute.values[count * n + c] = attribute.values[v * n + c];
        }
        ++count;
    }
    mesh.positions.resize(count);
    for (VertexAttribute& attribute : mesh.attributes)
        attribute.values.resize(count * static_cast<std::size_t>(attribute.components));
    for (auto& t : mesh.triangles)
        for (std::uint32_t& corner : t) corner = number[corner];
}

}  // namespace

void drop_small_components(TriMesh& mesh, double min_area_mm2) {
    Components components(mesh.positions.size());
    for (const auto& t : mesh.triangles) {
        components.join(t[0], t[1]);
        components.join(t[0], t[2]);
    }
    const std::vector<float>& filled = mesh.find_attribute("filled")->values;
    std::vector<double> area(mesh.positions.size(), 0);
    for (const auto& t : mesh.triangles)
        if (filled[t[0]] == 0 && filled[t[1]] == 0 && filled[t[2]] == 0)
            area[components.find(t[0])] += area_vector(mesh, t).norm();
    std::vector<std::uint8_t> keep(mesh.positions.size(), 0);
    std::size_t kept = 0;
    for (const auto& t : mesh.triangles) {
        const double component_area = area[components.find(t[0])];
        if (!(component_area > 0) || component_area < min_area_mm2) continue;
        for (const std::uint32_t corner : t) keep[corner] = 1;
        mesh.triangles[kept++] = t;
    }
    mesh.triangles.resize(kept);
    compact(mesh, keep);
}

void smooth_filled(TriMesh& mesh, int rounds) {
    const std::vector<float>& filled = mesh.find_attribute("filled")->values;
    std::vector<std::array<std::uint32_t, 2>> steps;  // vertex that moves, neighbour
    for (const auto& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t other = 1; other < 3; ++other)
                if (filled[t[k]] != 0) steps.push_back({t[k], t[(k + other) % 3]});
    std::vector<Eigen::Vector3d> sum(mesh.positions.size());
    std::vector<std::uint32_t> count(mesh.positions.size(), 0);
    for (const auto& [vertex, neighbour] : steps) ++count[vertex];
    for (int round = 0; round < rounds; ++round) {
        std::fill(sum.begin(), sum.end(), Eigen::Vector3d::Zero());
        for (const auto& [vertex, neighbour] : steps) sum[vertex] += mesh.positions[neighbour];
        for (std::size_t v = 0; v < sum.size(); ++v)
            if (count[v] > 0) mesh.positions[v] = 0.5 * (mesh.positions[v] + sum[v] / count[v]);
    }
}

void add_normals(TriMesh& mesh) {
    std::vector<Eigen::Vector3d> sum(mesh.positions.size(), Eigen::Vector3d::Zero());
    for (const auto& t : mesh.triangles) {
        const Eigen::Vector3d area = area_vector(mesh, t);
        for (const std::uint32_t corner : t) sum[corner] += area;
    }
    VertexAttribute normal = {"normal", 3, std::vector<float>(3 * sum.size(), 0)};
    for (std::size_t v = 0; v < sum.size(); ++v) {
        const double length = sum[v].norm();
        for (int k = 0; k < 3 && length > 0; ++k)
            normal.values[3 * v + static_cast<std::size_t>(k)] =
                static_cast<float>(sum[v][k] / length);
    }
    mesh.attributes.push_back(std::move(normal));
}

}  // namespace stria

#include "host/render/cluster.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <unordered_map>

namespace stria {
namespace {

struct CellHash {
    std::size_t operator()(const std::array<std::int64_t, 3>& cell) const {
        std::size_t hash = 0;
        for (const std::int64_t c : cell)
            hash = hash * 1000003U + static_cast<std::size_t>(c + (std::int64_t{1} << 32));
        return hash;
    }
};

}  // namespace

TriMesh clustered(const TriMesh& mesh, double cell_mm) {
    if (!(cell_mm > 0)) throw std::invalid_argument("clustered: cell_mm must be above 0");
    TriMesh small;
    for (const VertexAttribute& attribute : mesh.attributes)
        small.attributes.push_back({attribute.name, attribute.components, {}});
    std::unordered_map<std::array<std::int64_t, 3>, std::uint32_t, CellHash> cells;
    std::vector<std::uint32_t> cell_of;
    std::vector<double> count;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        std::array<std::int64_t, 3> key;
        for (int k = 0; k < 3; ++k)
            key[static_cast<std::size_t>(k)] = std::llround(mesh.positions[i][k] / cell_mm);
        const auto [at, added] =
            cells.try_emplace(key, static_cast<std::uint32_t>(small.positions.size()));
        if (added) {
            small.positions.emplace_back(Eigen::Vector3d::Zero());
            count.push_back(0);
            for (auto& attribute : small.attributes)
                attribute.values.resize(attribute.values.size() +
                                        static_cast<std::size_t>(attribute.components));
        }
        const std::uint32_t cell = at->second;
        cell_of.push_back(cell);
        small.positions[cell] += mesh.positions[i];
        count[cell] += 1;
        for (std::size_t a = 0; a < small.attributes.size(); ++a) {
            const auto n = static_cast<std::size_t>(small.attributes[a].components);
            for (std::size_t c = 0; c < n; ++c)
                small.attributes[a].values[cell * n + c] += mesh.attributes[a].values[i * n + c];
        }
    }
    for (std::size_t i = 0; i < small.positions.size(); ++i) {
        small.positions[i] /= count[i];
        for (auto& attribute : small.attributes) {
            const auto n = static_cast<std::size_t>(attribute.components);
            for (std::size_t c = 0; c < n; ++c)
                attribute.values[i * n + c] /= static_cast<float>(count[i]);
        }
    }
    std::set<std::array<std::uint32_t, 3>> seen;
    for (const auto& t : mesh.triangles) {
        std::array<std::uint32_t, 3> corners = {cell_of[t[0]], cell_of[t[1]], cell_of[t[2]]};
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
            continue;
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
        if (seen.insert(corners).second) small.triangles.push_back(corners);
    }
    return small;
}

}  // namespace stria

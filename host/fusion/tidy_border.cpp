#include "host/fusion/tidy_border.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <map>
#include <unordered_map>
#include <unordered_set>

namespace stria {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::uint64_t directed(std::uint32_t from, std::uint32_t to) {
    return std::uint64_t{from} << 32 | to;
}
std::uint64_t undirected(std::uint32_t a, std::uint32_t b) {
    return directed(std::min(a, b), std::max(a, b));
}

std::uint64_t scrambled(std::uint64_t x) {  // splitmix64
    x += 0x9e3779b97f4a7c15;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
    x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
    return x ^ (x >> 31);
}

/// Vertices at the border. Round any other vertex every neighbour comes once as the next and once
/// as the last corner of a triangle, so that its sum is zero.
std::vector<std::uint8_t> border_vertices(const TriMesh& mesh) {
    std::vector<std::uint64_t> sum(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            sum[t[k]] += scrambled(t[(k + 1) % 3]);
            sum[t[k]] -= scrambled(t[(k + 2) % 3]);
        }
    std::vector<std::uint8_t> at_border(sum.size());
    for (std::size_t v = 0; v < sum.size(); ++v) at_border[v] = sum[v] != 0;
    return at_border;
}

/// Border sides, directed as their triangles run, with the triangle.
using Border = std::map<std::uint64_t, std::uint32_t>;

/// @param at_border  vertices that border sides may join; taking off and closing makes no others
Border find_border(const TriMesh& mesh, const std::vector<std::uint8_t>& at_border) {
    std::unordered_map<std::uint64_t, int> uses;
    Border border;
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = mesh.triangles[i][k], b = mesh.triangles[i][(k + 1) % 3];
            if (!at_border[a] || !at_border[b]) continue;
            ++uses[undirected(a, b)];
            border.emplace(directed(a, b), i);
        }
    std::erase_if(border, [&](const auto& entry) {
        return uses[undirected(static_cast<std::uint32_t>(entry.first >> 32),
                               static_cast<std::uint32_t>(entry.first & 0xffffffffu))] != 1;
    });
    return border;
}

/// Removes triangles with two or three border sides.
bool take_off_teeth(TriMesh& mesh, const Border& border) {
    std::unordered_map<std::uint32_t, int> sides;
    for (const auto& [side, triangle] : border) ++sides[triangle];
    std::uint32_t number = 0;
    return std::erase_if(mesh.triangles, [&](const Triangle&) {
               const auto found = sides.find(number++);
               return found != sides.end() && found->second > 1;
           }) > 0;
}

class NotchCloser {
  public:
    NotchCloser(TriMesh& mesh, const Border& border, double max_gap_mm)
        : mesh_(mesh), border_(border), max_squared_(max_gap_mm * max_gap_mm) {
        std::vector<std::uint8_t> at_border(mesh.positions.size(), 0);
        for (const auto& [side, triangle] : border)
            at_border[side >> 32] = at_border[side & 0xffffffffu] = 1;
        for (const Triangle& t : mesh.triangles)
            for (std::size_t k = 0; k < 3; ++k)
                if (at_border[t[k]] && at_border[t[(k + 1) % 3]])
                    sides_.insert(undirected(t[k], t[(k + 1) % 3]));
        for (const auto& [side, triangle] : border)
            if (!next_.emplace(side >> 32, side & 0xffffffffu).second)
                branching_.insert(static_cast<std::uint32_t>(side >> 32));
    }

    bool close() {
        bool any = false;
        for (const auto& [side, triangle] : border_) {
            const auto a = static_cast<std::uint32_t>(side >> 32);
            const auto b = static_cast<std::uint32_t>(side & 0xffffffffu);
            const auto after = next_.find(b);
            if (after == next_.end() || branching_.count(b) || touched_.count(b)) continue;
            if (touched_.count(a) || touched_.count(after->second)) continue;
            any |= try_close(a, b, after->second, triangle);
        }
        return any;
    }

  private:
    bool try_close(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t triangle) {
        if (a == c || sides_.count(undirected(a, c)) > 0) return false;
        if ((mesh_.positions[a] - mesh_.positions[c]).squaredNorm() > max_squared_) return false;
        const Triangle closing = {c, b, a};
        const auto other = border_.find(directed(b, c));
        if (!agrees(closing, triangle) || !agrees(closing, other->second)) return false;
        mesh_.triangles.push_back(closing);
        sides_.insert(undirected(a, c));
        touched_.insert({a, b, c});
        return true;
    }

    Eigen::Vector3d normal(const Triangle& t) const {
        const Eigen::Vector3d& a = mesh_.positions[t[0]];
        return (mesh_.positions[t[1]] - a).cross(mesh_.positions[t[2]] - a).normalized();
    }
    bool agrees(const Triangle& closing, std::uint32_t neighbour) const {
        return normal(closing).dot(normal(mesh_.triangles[neighbour])) > 0.5;
    }

    TriMesh& mesh_;
    const Border& border_;
    double max_squared_;
    std::unordered_set<std::uint64_t> sides_;
    std::unordered_map<std::uint32_t, std::uint32_t> next_;
    std::unordered_set<std::uint32_t> branching_, touched_;
};

}  // namespace

void tidy_border(TriMesh& mesh, double max_gap_mm, int rounds) {
    const std::vector<std::uint8_t> at_border = border_vertices(mesh);
    for (int round = 0; round < rounds; ++round) {
        const bool fewer = take_off_teeth(mesh, find_border(mesh, at_border));
        const Border border = find_border(mesh, at_border);
        if (!NotchCloser(mesh, border, max_gap_mm).close() && !fewer) return;
    }
}

}  // namespace stria

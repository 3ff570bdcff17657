#include "host/fusion/cube_cases.h"

#include <cassert>
#include <optional>

namespace stria {
namespace {

using Loop = std::vector<std::uint8_t>;
using Cut = std::vector<std::array<std::uint8_t, 3>>;

/// Six faces, each four corners counter-clockwise seen from outside the cube.
using Faces = std::array<std::array<std::uint8_t, 4>, 6>;

std::array<CubeEdge, 12> make_edges() {
    std::array<CubeEdge, 12> edges{};
    std::size_t count = 0;
    for (std::uint8_t axis = 0; axis < 3; ++axis)
        for (std::uint8_t corner = 0; corner < 8; ++corner)
            if (!(corner >> axis & 1)) edges[count++] = {corner, axis};
    return edges;
}

Faces make_faces() {
    Faces faces{};
    for (unsigned axis = 0; axis < 3; ++axis)
        for (unsigned side = 0; side < 2; ++side) {
            const unsigned base = side << axis;
            const unsigned u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3;
            const auto c = [&](unsigned extra) { return static_cast<std::uint8_t>(base | extra); };
            faces[2 * axis + side] = {c(0), c(side ? u : v), c(u | v), c(side ? v : u)};
        }
    return faces;
}

class CaseMaker {
  public:
    CaseMaker() : edges_(make_edges()), faces_(make_faces()) {
        for (std::size_t f = 0; f < faces_.size(); ++f)
            for (std::size_t k = 0; k < 4; ++k)
                faces_of_[edge_between(faces_[f][k], faces_[f][(k + 1) % 4])] |=
                    static_cast<std::uint8_t>(1u << f);
    }

    const std::array<CubeEdge, 12>& edges() const { return edges_; }

    Cut triangles(unsigned inside) const {
        Cut all;
        for (const Loop& loop : loops(inside)) {
            const std::optional<Cut> cut = cut_loop(loop, 0, loop.size() - 1);
            assert(cut);
            all.insert(all.end(), cut->begin(), cut->end());
        }
        return all;
    }

  private:
    std::uint8_t edge_between(unsigned a, unsigned b) const {
        const unsigned low = a < b ? a : b;
        for (std::uint8_t e = 0; e < 12; ++e)
            if (edges_[e].low == low && (low | 1u << edges_[e].axis) == (a < b ? b : a)) return e;
        assert(false);
        return 0;
    }

    /// Follows the segments of the faces from edge to edge.
    std::vector<Loop> loops(unsigned inside) const {
        constexpr std::uint8_t kNone = 255;
        std::array<std::uint8_t, 12> next;
        next.fill(kNone);
        for (const auto& face : faces_)
            for (std::size_t k = 0; k < 4; ++k) {
                // Going round, enter the inside between corners k and k + 1; leave it at the end of
                // that run of inside corners.
                if ((inside >> face[k] & 1) || !(inside >> face[(k + 1) % 4] & 1)) continue;
                std::size_t end = k + 1;
                while (inside >> face[(end + 1) % 4] & 1) ++end;
                next[edge_between(face[k], face[(k + 1) % 4])] =
                    edge_between(face[end % 4], face[(end + 1) % 4]);
            }
        std::vector<Loop> all;
        for (std::uint8_t start = 0; start < 12; ++start) {
            Loop loop;
            for (std::uint8_t e = start; next[e] != kNone;) {
                loop.push_back(e);
                const std::uint8_t following = next[e];
                next[e] = kNone;
                e = following;
            }
            if (!loop.empty()) all.push_back(loop);
        }
        return all;
    }

    /// Triangles of loop[first..last] such that no diagonal joins two edges of one face.
    std::optional<Cut> cut_loop(const Loop& loop, std::size_t first, std::size_t last) const {
        if (last - first < 2) return Cut{};
        for (std::size_t middle = first + 1; middle < last; ++middle) {
            if (!may_join(loop, first, middle) || !may_join(loop, middle, last)) continue;
            auto left = cut_loop(loop, first, middle);
            auto right = cut_loop(loop, middle, last);
            if (!left || !right) continue;
            left->push_back({loop[first], loop[middle], loop[last]});
            left->insert(left->end(), right->begin(), right->end());
            return left;
        }
        return std::nullopt;
    }

    bool may_join(const Loop& loop, std::size_t a, std::size_t b) const {
        return b - a == 1 || !(faces_of_[loop[a]] & faces_of_[loop[b]]);
    }

    std::array<CubeEdge, 12> edges_;
    Faces faces_;
    std::array<std::uint8_t, 12> faces_of_{};
};

CubeCases make_cases() {
    const CaseMaker maker;
    CubeCases cases;
    cases.edges = maker.edges();
    for (unsigned inside = 0; inside < 256; ++inside)
        cases.triangles[inside] = maker.triangles(inside);
    return cases;
}

}  // namespace

const CubeCases& cube_cases() {
    static const CubeCases cases = make_cases();
    return cases;
}

}  // namespace stria

#pragma once
#include <array>
#include <cstdint>
#include <vector>

namespace stria {

/// Edge e (0..11) of a cube cell: from corner `low` along `axis`; corner c lies at
/// (c & 1, c >> 1 & 1, c >> 2 & 1).
struct CubeEdge {
    std::uint8_t low;
    std::uint8_t axis;
};

/// How the surface crosses a cell, for each of the 256 choices of corners that are inside.
struct CubeCases {
    std::array<CubeEdge, 12> edges;
    /// Triangles as edge numbers, counter-clockwise seen from outside; bit c of the index is set
    /// where corner c is inside.
    std::array<std::vector<std::array<std::uint8_t, 3>>, 256> triangles;
};

/// The table, made once by a rule instead of a list: in each face a segment cuts off every inside
/// corner by itself where the face is ambiguous, which both cells at a face decide alike; segments
/// close to loops; loops are cut by diagonals that lie in no face, so that no edge of the mesh gets
/// more than two triangles. The program makes sure at start that every loop has such a cut.
/// Source: marching cubes, Lorensen & Cline 1987; face rule as in Bloomenthal 1988.
const CubeCases& cube_cases();

}  // namespace stria

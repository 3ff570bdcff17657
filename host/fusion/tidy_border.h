#pragma once
#include "host/core/tri_mesh.h"

namespace stria {

/// Makes the ragged border that cutting a surface cell by cell leaves straighter, `rounds` times:
/// takes off teeth (triangles that hang on the mesh by one side) and closes notches (two border
/// edges in a row whose far ends are at most max_gap_mm apart get a triangle, if it turns less than
/// 60 deg against the two it joins). No vertex is made or moved; a hole no wider than max_gap_mm
/// may close. No edge gets more than two triangles if none had.
void tidy_border(TriMesh& mesh, double max_gap_mm, int rounds);

}  // namespace stria

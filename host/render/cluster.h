#pragma once
#include "host/core/tri_mesh.h"

namespace stria {

/// The mesh with all vertices of a cube of side cell_mm drawn together into their mean, attributes
/// alike, collapsed and doubled triangles left out: small enough for a page, for looking only.
/// Source: Rossignac & Borrel 1993, vertex clustering. Throws std::invalid_argument unless cell_mm
/// > 0.
TriMesh clustered(const TriMesh& mesh, double cell_mm);

}  // namespace stria

#pragma once
#include <string>
#include <vector>

#include "host/core/tri_mesh.h"

namespace stria {

/// One closed solid of the sculpture; solids overlap, their union is the object.
struct SculpturePart {
    std::string name;
    TriMesh mesh;  ///< mm, object frame; attributes "albedo" (1) and "relief" (1: 1 where it has
                   ///< fine relief)
};

/// The demo's object, about 150 mm: a smooth body with a patch of fine relief, a ball, a ring, a
/// cup (deep concavity), a thin wall, a plinth and a wedge (sharp edges), painted with a 5:1
/// pattern.
std::vector<SculpturePart> make_sculpture();

/// All parts in one mesh, in order, with the attribute "albedo".
TriMesh merged(const std::vector<SculpturePart>& parts);

}  // namespace stria

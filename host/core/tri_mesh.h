#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace stria {

/// Named numbers at the vertices, `components` each, vertex-major: "normal" (3), "colour" (3,
/// 0..1), "sigma" (1, mm), "filled" (1: 1 where the surface was not seen), "error" (1, mm) ...
struct VertexAttribute {
    std::string name;
    int components = 1;
    std::vector<float> values;
};

/// Triangles, counter-clockwise seen from outside; next vertex of a corner is implicit.
struct TriMesh {
    std::vector<Eigen::Vector3d> positions;  ///< mm
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<VertexAttribute> attributes;

    const VertexAttribute* find_attribute(const std::string& name) const {
        for (const VertexAttribute& attribute : attributes)
            if (attribute.name == name) return &attribute;
        return nullptr;
    }
    VertexAttribute* find_attribute(const std::string& name) {
        for (VertexAttribute& attribute : attributes)
            if (attribute.name == name) return &attribute;
        return nullptr;
    }
};

/// Points without grid or triangles, with what is known of them (attributes as in TriMesh).
struct PointCloud {
    std::vector<Eigen::Vector3d> positions;
    std::vector<VertexAttribute> attributes;
    std::size_t dropped = 0;  ///< points of the file without finite coordinates, left out
};

}  // namespace stria

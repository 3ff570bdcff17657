#pragma once
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "host/core/errors.h"
#include "host/core/tri_mesh.h"

namespace stria {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
    return {reinterpret_cast<const char*>(data), size};
}

/// Runs a reader: a stria::Error is a right answer, anything else that is thrown ends the program.
template <typename Read>
int read_or_refuse(Read&& read) {
    try {
        read();
    } catch (const Error&) {
    }
    return 0;
}

inline void require(bool holds) {
    if (!holds) std::abort();
}

inline void require_attributes(const std::vector<VertexAttribute>& attributes, std::size_t rows) {
    for (const VertexAttribute& attribute : attributes)
        require(attribute.components > 0 &&
                attribute.values.size() == rows * static_cast<std::size_t>(attribute.components));
}

/// What every reader of meshes promises: indices in range, finite positions, whole attributes.
inline void require_whole(const TriMesh& mesh) {
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t corner : triangle) require(corner < mesh.positions.size());
    for (const Eigen::Vector3d& position : mesh.positions) require(position.allFinite());
    require_attributes(mesh.attributes, mesh.positions.size());
}

inline void require_whole(const PointCloud& cloud) {
    for (const Eigen::Vector3d& position : cloud.positions) require(position.allFinite());
    require_attributes(cloud.attributes, cloud.positions.size());
}

}  // namespace stria

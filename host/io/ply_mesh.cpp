#include <cmath>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/ply_file.h"
#include "host/io/ply_writer.h"

namespace stria {
namespace {

struct Vertices {
    std::vector<Eigen::Vector3d> positions;
    std::vector<VertexAttribute> attributes;
};

/// What full intensity is in a colour column of that type.
double full_scale(PlyType type) {
    switch (type) {
        case PlyType::u8:
            return 255.0;
        case PlyType::u16:
            return 65535.0;
        default:
            return 1.0;
    }
}

Vertices take_vertices(PlyFile& file, const std::string& name) {
    Vertices vertices;
    for (PlyTable& table : file.tables) {
        if (table.element.name != "vertex") continue;
        const PlyColumn* columns[3];
        const char* const kNames[3] = {"x", "y", "z"};
        for (int k = 0; k < 3; ++k)
            if (!(columns[k] = table.scalars(kNames[k])))
                throw FileError(name, "element vertex",
                                std::string("expected property '") + kNames[k] + "', found none");
        vertices.positions.resize(table.element.count);
        for (std::size_t i = 0; i < vertices.positions.size(); ++i)
            vertices.positions[i] = {columns[0]->values[i], columns[1]->values[i],
                                     columns[2]->values[i]};
        std::vector<NamedColumn> others;
        for (std::size_t c = 0; c < table.columns.size(); ++c) {
            const PlyProperty& property = table.element.properties[c];
            if (property.is_list || property.name == "x" || property.name == "y" ||
                property.name == "z")
                continue;
            others.push_back(
                {property.name, std::move(table.columns[c].values), full_scale(property.type)});
        }
        vertices.attributes = attributes_from(std::move(others));
        return vertices;
    }
    throw FileError(name, "header", "expected an element vertex, found none");
}

const PlyColumn* find_indices(const PlyTable& table) {
    for (const char* name : {"vertex_indices", "vertex_index"})
        if (const PlyColumn* lists = table.lists(name)) return lists;
    return nullptr;
}

/// The vertex index in a list's value.
std::uint32_t index_of(double value, std::size_t vertices, const std::string& name,
                       const std::string& element, std::size_t row) {
    if (!(value >= 0 && value < static_cast<double>(vertices)) || value != std::floor(value))
        throw FileError(name, "element " + element + ", row " + std::to_string(row),
                        "expected a vertex index of 0 to " +
                            std::to_string(static_cast<std::int64_t>(vertices) - 1) + ", found " +
                            std::to_string(value));
    return static_cast<std::uint32_t>(value);
}

void take_faces(const PlyTable& table, const std::string& name, TriMesh& mesh) {
    const PlyColumn* lists = find_indices(table);
    if (!lists) {
        if (table.element.count == 0) return;
        throw FileError(name, "element face",
                        "expected a list vertex_indices or vertex_index, found none");
    }
    if (mesh.triangles.empty()) mesh.triangles.reserve(lists->values.size() / 3);
    for (std::size_t row = 0; row < table.element.count; ++row) {
        const std::size_t begin = lists->begin[row], end = lists->begin[row + 1];
        const auto corner = [&](std::size_t i) {
            return index_of(lists->values[i], mesh.positions.size(), name, "face", row);
        };
        for (std::size_t i = begin; i < end && end - begin < 3; ++i)
            corner(i);  // checked all the same
        for (std::size_t i = begin + 2; i < end; ++i)
            mesh.triangles.push_back({corner(begin), corner(i - 1), corner(i)});
    }
}

/// Strips parted by -1; every other triangle is turned over.
void take_strips(const PlyTable& table, const std::string& name, TriMesh& mesh) {
    const PlyColumn* lists = find_indices(table);
    if (!lists) return;
    for (std::size_t row = 0; row < table.element.count; ++row) {
        std::size_t length = 0;
        std::uint32_t a = 0, b = 0;
        for (std::size_t i = lists->begin[row]; i < lists->begin[row + 1]; ++i) {
            if (lists->values[i] == -1) {
                length = 0;
                continue;
            }
            const std::uint32_t c =
                index_of(lists->values[i], mesh.positions.size(), name, "tristrips", row);
            if (length >= 2)
                mesh.triangles.push_back(length % 2 == 0 ? std::array{a, b, c}
                                                         : std::array{b, a, c});
            a = b;
            b = c;
            ++length;
        }
    }
}

void check_finite(const std::vector<Eigen::Vector3d>& positions, const std::string& name) {
    for (std::size_t i = 0; i < positions.size(); ++i)
        if (!positions[i].allFinite())
            throw FileError(name, "element vertex, row " + std::to_string(i),
                            "expected finite coordinates");
}

/// Colours are written as bytes.
bool is_colour(const VertexAttribute& attribute) {
    return attribute.name == "colour" && attribute.components == 3;
}

std::string format_header(std::size_t vertices, std::size_t triangles,
                          const std::vector<VertexAttribute>& attributes, bool with_faces) {
    std::string text = "ply\nformat binary_little_endian 1.0\ncomment stria " STRIA_VERSION "\n";
    text += "element vertex " + std::to_string(vertices) + "\n";
    text += "property float x\nproperty float y\nproperty float z\n";
    for (const VertexAttribute& attribute : attributes)
        for (const std::string& name : component_names(attribute))
            text += (is_colour(attribute) ? "property uchar " : "property float ") + name + "\n";
    if (with_faces)
        text += "element face " + std::to_string(triangles) +
                "\nproperty list uchar int vertex_indices\n";
    return text + "end_header\n";
}

std::uint8_t byte_of(float value) {
    if (!(value > 0)) return 0;  // NaN too
    return static_cast<std::uint8_t>(std::lround(255.0F * std::min(value, 1.0F)));
}

}  // namespace

TriMesh parse_ply_mesh(std::string_view bytes, const std::string& name) {
    PlyFile file = parse_ply(bytes, name);
    Vertices vertices = take_vertices(file, name);
    TriMesh mesh;
    mesh.positions = std::move(vertices.positions);
    mesh.attributes = std::move(vertices.attributes);
    check_finite(mesh.positions, name);
    if (const PlyTable* faces = file.find("face")) take_faces(*faces, name, mesh);
    if (const PlyTable* strips = file.find("tristrips")) take_strips(*strips, name, mesh);
    return mesh;
}

PointCloud parse_ply_points(std::string_view bytes, const std::string& name) {
    PlyFile file = parse_ply(bytes, name);
    Vertices vertices = take_vertices(file, name);
    PointCloud cloud;
    cloud.positions = std::move(vertices.positions);
    cloud.attributes = std::move(vertices.attributes);
    drop_points_not_finite(cloud);
    return cloud;
}

std::string format_ply(const std::vector<Eigen::Vector3d>& positions,
                       const std::vector<std::array<std::uint32_t, 3>>& triangles,
                       const std::vector<VertexAttribute>& attributes, bool with_faces) {
    std::string bytes = format_header(positions.size(), triangles.size(), attributes, with_faces);
    std::size_t row_bytes = 12;
    for (const VertexAttribute& attribute : attributes)
        row_bytes += 4 * static_cast<std::size_t>(attribute.components);
    bytes.reserve(bytes.size() + row_bytes * positions.size() + 13 * triangles.size());
    LittleEndianBytes out(bytes);
    for (std::size_t i = 0; i < positions.size(); ++i) {
        for (int k = 0; k < 3; ++k) out.put_float(positions[i][k]);
        for (const VertexAttribute& attribute : attributes) {
            const auto n = static_cast<std::size_t>(attribute.components);
            for (std::size_t k = 0; k < n; ++k) {
                const float value = attribute.values[i * n + k];
                if (is_colour(attribute))
                    out.put(byte_of(value));
                else
                    out.put(value);
            }
        }
    }
    for (const auto& triangle : triangles) {
        out.put(std::uint8_t{3});
        for (const std::uint32_t corner : triangle) out.put(static_cast<std::int32_t>(corner));
    }
    return bytes;
}

}  // namespace stria

#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "host/core/tri_mesh.h"

/// The formats behind mesh_io.h, one or two files each. Readers take the bytes and a name that
/// stands for the path in errors; positions come in the file's unit, read_mesh scales them.
namespace stria {

TriMesh parse_ply_mesh(std::string_view bytes, const std::string& name);
TriMesh parse_obj(std::string_view bytes, const std::string& name);
TriMesh parse_stl(std::string_view bytes, const std::string& name);
TriMesh parse_off(std::string_view bytes, const std::string& name);
PointCloud parse_ply_points(std::string_view bytes, const std::string& name);
PointCloud parse_pcd(std::string_view bytes, const std::string& name);
/// XYZ and CSV: numbers parted by white space, commas or semicolons.
PointCloud parse_xyz(std::string_view bytes, const std::string& name);

std::string format_ply(const std::vector<Eigen::Vector3d>& positions,
                       const std::vector<std::array<std::uint32_t, 3>>& triangles,
                       const std::vector<VertexAttribute>& attributes, bool with_faces);
std::string format_obj(const TriMesh& mesh);
std::string format_stl(const TriMesh& mesh);
std::string format_off(const TriMesh& mesh);
std::string format_glb(const TriMesh& mesh);
std::string format_pcd(const PointCloud& cloud);
/// @param separator  ' ' for XYZ, ',' for CSV, which also gets a header line
std::string format_xyz(const PointCloud& cloud, char separator);

/// Decompresses LZF (liblzf's format) into exactly `size` bytes; empty if the data is not that.
std::string lzf_decompress(std::string_view compressed, std::size_t size);

/// Throws FileError for text in UTF-16 or UTF-32, known by its byte order mark or by zero bytes.
/// Returns the text without a UTF-8 mark.
std::string_view plain_text(std::string_view bytes, const std::string& name);

/// Columns "nx ny nz" become "normal", "red green blue" become "colour", "a_0 a_1" become "a" with
/// two components, others keep their names. `scale` of a column is what its 1 stands for (255 for
/// uchar colours), used for colours only.
struct NamedColumn {
    std::string name;
    std::vector<double> values;
    double scale = 1.0;
};
std::vector<VertexAttribute> attributes_from(std::vector<NamedColumn> columns);

/// One name a component: the inverse of the grouping in attributes_from. Blanks become '_'.
std::vector<std::string> component_names(const VertexAttribute& attribute);

/// Points whose coordinates are the columns x, y and z, the others being attributes; those that are
/// not finite are left out. Throws FileError if one of the three is missing.
PointCloud cloud_from_columns(std::vector<NamedColumn> columns, const std::string& name);

/// Removes points that are not finite, with their attributes; counts them in cloud.dropped.
void drop_points_not_finite(PointCloud& cloud);

}  // namespace stria

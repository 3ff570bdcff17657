#pragma once
#include <string>
#include <variant>

#include "host/core/tri_mesh.h"

namespace stria {

/// Factor from the unit of a file to mm: "mm", "m", "um", "in". Throws stria::Error otherwise.
double mm_per_unit(const std::string& unit);

struct MeshReadOptions {
    double mm_per_unit = 1.0;  ///< positions are multiplied by it
};

/// Reads a mesh by its ending, whatever its case: PLY (ascii, both binary orders), OBJ, STL (ascii,
/// binary; vertices merged exactly), OFF. Polygons are cut into triangle fans. Normals, colours and
/// other scalar vertex properties become attributes. A file of points alone gives a mesh without
/// triangles. Throws FileError with place, expected and found; memory is bounded by the file's
/// size.
TriMesh read_mesh(const std::string& path, const MeshReadOptions& options = {});

/// Writes by the ending: PLY (binary little endian), OBJ, STL (binary), OFF, GLB; whole or not at
/// all. GLB carries normals and colours where present.
void write_mesh(const std::string& path, const TriMesh& mesh);

/// Points without grid: PLY, PCD (ascii, binary, binary_compressed), XYZ, CSV.
PointCloud read_points(const std::string& path, const MeshReadOptions& options = {});
void write_points(const std::string& path, const PointCloud& cloud);  ///< PLY, PCD, XYZ, CSV

}  // namespace stria

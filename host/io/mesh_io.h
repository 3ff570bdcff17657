#pragma once
#include <string>
#include <string_view>

#include "host/core/tri_mesh.h"

namespace stria {

/// Factor from the unit of a file to mm: "mm", "m", "um", "in". Throws stria::Error otherwise.
double mm_per_unit(const std::string& unit);

struct MeshReadOptions {
    double mm_per_unit = 1.0;  ///< positions are multiplied by it
};

/// Reads a mesh by its ending, whatever its case: PLY (ascii, both binary orders), OBJ, STL (ascii,
/// binary; vertices merged exactly), OFF. Polygons are cut into triangle fans. Scalar vertex
/// properties become attributes: nx ny nz "normal", red green blue "colour" (0..1), others keep
/// their names. OBJ's normals stand at corners: a vertex gets their mean. A file of points alone
/// gives a mesh without triangles.
/// Throws FileError with place, expected and found, also for coordinates that are not finite;
/// memory is bounded by the file's size.
TriMesh read_mesh(const std::string& path, const MeshReadOptions& options = {});
/// The same from memory; `name` stands for the path, and its ending says the format.
TriMesh parse_mesh(std::string_view bytes, const std::string& name,
                   const MeshReadOptions& options = {});

/// Writes by the ending: PLY (binary little endian, float), OBJ, STL (binary), OFF, GLB; whole or
/// not at all. PLY carries every attribute, OBJ and GLB normals and colours; GLB's unit is the
/// metre.
void write_mesh(const std::string& path, const TriMesh& mesh);

/// Points without grid: PLY, PCD (ascii, binary, binary_compressed), XYZ (also .txt, .asc), CSV
/// with or without a header; of a mesh file its vertices. XYZ and CSV without a header: x y z, x y
/// z intensity, or x y z nx ny nz where the last three are unit vectors; further columns become
/// attributes "column4" ... Points that are not finite are left out and counted in `dropped`.
PointCloud read_points(const std::string& path, const MeshReadOptions& options = {});
PointCloud parse_points(std::string_view bytes, const std::string& name,
                        const MeshReadOptions& options = {});
/// PLY, PCD (binary), CSV with a header, XYZ (positions and normals).
void write_points(const std::string& path, const PointCloud& cloud);
/// True for endings that can only mean points: .pcd .xyz .csv .txt .asc.
bool is_points_only_path(const std::string& path);

}  // namespace stria

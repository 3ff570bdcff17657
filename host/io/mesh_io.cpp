#include "host/io/mesh_io.h"

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

/// The ending in lower case, without its dot.
std::string ending_of(const std::string& path) {
    const std::size_t dot = path.rfind('.');
    if (dot == std::string::npos || path.find('/', dot) != std::string::npos) return "";
    std::string ending = path.substr(dot + 1);
    for (char& c : ending)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return ending;
}

template <typename Content>
void scale(Content& content, double factor) {
    if (factor == 1.0) return;
    for (Eigen::Vector3d& position : content.positions) position *= factor;
}

[[noreturn]] void refuse(const std::string& path, const std::string& expected) {
    const std::string ending = ending_of(path);
    throw FileError(path, "",
                    "expected a file ending in " + expected +
                        (ending.empty() ? ", found no ending" : ", found ." + ending));
}

bool is_cloud_ending(const std::string& ending) {
    return ending == "pcd" || ending == "xyz" || ending == "csv" || ending == "txt" ||
           ending == "asc";
}

}  // namespace

double mm_per_unit(const std::string& unit) {
    if (unit == "mm") return 1.0;
    if (unit == "m") return 1000.0;
    if (unit == "um") return 0.001;
    if (unit == "in") return 25.4;
    throw Error("unit '" + unit + "': expected mm, m, um or in");
}

bool is_points_only_path(const std::string& path) { return is_cloud_ending(ending_of(path)); }

TriMesh parse_mesh(std::string_view bytes, const std::string& name,
                   const MeshReadOptions& options) {
    const std::string ending = ending_of(name);
    TriMesh mesh;
    if (ending == "ply")
        mesh = parse_ply_mesh(bytes, name);
    else if (ending == "obj")
        mesh = parse_obj(bytes, name);
    else if (ending == "stl")
        mesh = parse_stl(bytes, name);
    else if (ending == "off")
        mesh = parse_off(bytes, name);
    else
        refuse(name, ".ply, .obj, .stl or .off");
    scale(mesh, options.mm_per_unit);
    return mesh;
}

TriMesh read_mesh(const std::string& path, const MeshReadOptions& options) {
    return parse_mesh(read_whole_file(path), path, options);
}

void write_mesh(const std::string& path, const TriMesh& mesh) {
    const std::string ending = ending_of(path);
    if (ending == "ply")
        write_whole_file(path, format_ply(mesh.positions, mesh.triangles, mesh.attributes, true));
    else if (ending == "obj")
        write_whole_file(path, format_obj(mesh));
    else if (ending == "stl")
        write_whole_file(path, format_stl(mesh));
    else if (ending == "off")
        write_whole_file(path, format_off(mesh));
    else if (ending == "glb")
        write_whole_file(path, format_glb(mesh));
    else
        refuse(path, ".ply, .obj, .stl, .off or .glb");
}

PointCloud parse_points(std::string_view bytes, const std::string& name,
                        const MeshReadOptions& options) {
    const std::string ending = ending_of(name);
    PointCloud cloud;
    if (ending == "ply")
        cloud = parse_ply_points(bytes, name);
    else if (ending == "pcd")
        cloud = parse_pcd(bytes, name);
    else if (is_cloud_ending(ending))
        cloud = parse_xyz(bytes, name);
    else if (ending == "obj" || ending == "stl" || ending == "off") {
        TriMesh mesh = parse_mesh(bytes, name, {});
        cloud.positions = std::move(mesh.positions);
        cloud.attributes = std::move(mesh.attributes);
    } else {
        refuse(name, ".ply, .pcd, .xyz, .csv, .txt, .asc, .obj, .stl or .off");
    }
    scale(cloud, options.mm_per_unit);
    return cloud;
}

PointCloud read_points(const std::string& path, const MeshReadOptions& options) {
    return parse_points(read_whole_file(path), path, options);
}

void write_points(const std::string& path, const PointCloud& cloud) {
    const std::string ending = ending_of(path);
    if (ending == "ply")
        write_whole_file(path, format_ply(cloud.positions, {}, cloud.attributes, false));
    else if (ending == "pcd")
        write_whole_file(path, format_pcd(cloud));
    else if (ending == "csv")
        write_whole_file(path, format_xyz(cloud, ','));
    else if (is_cloud_ending(ending))
        write_whole_file(path, format_xyz(cloud, ' '));
    else
        refuse(path, ".ply, .pcd, .xyz or .csv");
}

}  // namespace stria

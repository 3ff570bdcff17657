// A mesh or a file of points; the first byte says of which format. What is read must be whole, and
// a mesh must be written and read again with the same triangles.
#include "host/io/mesh_formats.h"
#include "tests/fuzz/fuzz_reader.h"

namespace stria {
namespace {

void check(const TriMesh& mesh) {
    require_whole(mesh);
    require(parse_off(format_off(mesh), "again").triangles == mesh.triangles);
    try {
        const auto bytes = format_ply(mesh.positions, mesh.triangles, mesh.attributes, true);
        require(parse_ply_mesh(bytes, "again").triangles == mesh.triangles);
    } catch (const FileError&) {  // coordinates beyond float are refused when read again
    }
}

void read(char format, std::string_view bytes) {
    switch (format) {
        case 'p':
            return check(parse_ply_mesh(bytes, "in.ply"));
        case 'o':
            return check(parse_obj(bytes, "in.obj"));
        case 's':
            return check(parse_stl(bytes, "in.stl"));
        case 'f':
            return check(parse_off(bytes, "in.off"));
        case 'y':
            return require_whole(parse_ply_points(bytes, "in.ply"));
        case 'd':
            return require_whole(parse_pcd(bytes, "in.pcd"));
        case 'x':
            return require_whole(parse_xyz(bytes, "in.xyz"));
        default:
            break;
    }
}

}  // namespace
}  // namespace stria

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace stria;
    if (size == 0) return 0;
    return read_or_refuse([&] { read(static_cast<char>(data[0]), text_of(data + 1, size - 1)); });
}

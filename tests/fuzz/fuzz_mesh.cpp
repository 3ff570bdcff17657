// A mesh or a file of points; the first byte says of which format. A mesh that is read must be
// written and read again with as many triangles.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "host/core/errors.h"
#include "host/io/mesh_formats.h"

namespace {

void check_round_trip(const stria::TriMesh& mesh) {
    const stria::TriMesh again = stria::parse_off(stria::format_off(mesh), "again");
    if (again.triangles.size() != mesh.triangles.size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
    try {
        switch (data[0]) {
            case 'p':
                check_round_trip(stria::parse_ply_mesh(bytes, "in.ply"));
                break;
            case 'o':
                check_round_trip(stria::parse_obj(bytes, "in.obj"));
                break;
            case 's':
                check_round_trip(stria::parse_stl(bytes, "in.stl"));
                break;
            case 'f':
                check_round_trip(stria::parse_off(bytes, "in.off"));
                break;
            case 'y':
                (void)stria::parse_ply_points(bytes, "in.ply");
                break;
            case 'd':
                (void)stria::parse_pcd(bytes, "in.pcd");
                break;
            case 'x':
                (void)stria::parse_xyz(bytes, "in.xyz");
                break;
            default:
                break;
        }
    } catch (const stria::Error&) {
    }
    return 0;
}

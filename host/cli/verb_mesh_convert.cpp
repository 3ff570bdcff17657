#include <filesystem>

#include "host/cli/command.h"
#include "host/cli/range_mesh.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/io/mesh_io.h"
#include "host/io/range_io.h"

namespace stria {
namespace {

/// Whatever the file holds: a range image becomes the triangles of its grid.
TriMesh read_anything(const std::string& path, double mm_per_unit) {
    if (is_points_only_path(path)) {
        PointCloud cloud = read_points(path, {.mm_per_unit = mm_per_unit});
        return {std::move(cloud.positions), {}, std::move(cloud.attributes)};
    }
    const std::string ending = std::filesystem::path(path).extension().string();
    if ((ending == ".ply" || ending == ".PLY") && has_range_grid(path))
        return range_mesh(read_range_image(path, mm_per_unit));
    return read_mesh(path, {.mm_per_unit = mm_per_unit});
}

class MeshConvert final : public Verb {
  public:
    std::string name() const override { return "mesh convert"; }
    std::string summary() const override {
        return "write a mesh, points or a range image in another format, in mm";
    }
    void declare(Arguments& arguments) override {
        arguments.positional("in", in_,
                             "PLY, OBJ, STL, OFF, PCD, XYZ, CSV; a range image is triangulated");
        arguments.option("--out", out_, "PLY, OBJ, STL, OFF, GLB; points: PLY, PCD, XYZ, CSV",
                         true);
    }
    int run(const Context& context) override {
        context.check_output(out_);
        const TriMesh mesh = read_anything(in_, context.mm_per_unit());
        if (is_points_only_path(out_))
            write_points(out_, {mesh.positions, mesh.attributes});
        else if (mesh.triangles.empty())
            write_bare_points(mesh);
        else
            write_mesh(out_, mesh);
        context.say(in_ + " -> " + out_ + ": " + std::to_string(mesh.positions.size()) +
                    " vertices, " + std::to_string(mesh.triangles.size()) + " triangles");
        context.finish(JsonResult()
                           .set("vertices", mesh.positions.size())
                           .set("triangles", mesh.triangles.size())
                           .set("out", out_));
        return 0;
    }

  private:
    /// PLY, OBJ, OFF and GLB can hold points alone, STL cannot.
    void write_bare_points(const TriMesh& mesh) const {
        const std::string ending = std::filesystem::path(out_).extension().string();
        if (ending == ".stl" || ending == ".STL")
            throw FileError(in_, "",
                            "expected triangles to write STL, found " +
                                std::to_string(mesh.positions.size()) + " points alone");
        if (ending == ".ply" || ending == ".PLY")
            write_points(out_, {mesh.positions, mesh.attributes});
        else
            write_mesh(out_, mesh);
    }

    std::string in_, out_;
};

}  // namespace

std::unique_ptr<Verb> make_mesh_convert_verb() { return std::make_unique<MeshConvert>(); }

}  // namespace stria

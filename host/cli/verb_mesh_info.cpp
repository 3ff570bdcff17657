#include "host/cli/verbs.h"
#include "host/io/mesh_io.h"
#include "host/mesh/mesh_info.h"

namespace stria {
namespace {

class MeshInfoVerb : public Verb {
  public:
    std::string name() const override { return "mesh info"; }
    std::string summary() const override { return "size and topology of a mesh"; }

    void declare(Arguments& arguments) override {
        arguments.positional("IN", in_, "mesh: PLY, OBJ, STL, OFF");
    }

    int run(const Context& context) override {
        const MeshInfo info = mesh_info(read_mesh(in_, {.mm_per_unit = context.mm_per_unit()}));
        context.say(in_ + ": " + std::to_string(info.vertices) + " vertices, " +
                    std::to_string(info.triangles) + " triangles, " +
                    std::to_string(info.components) + " components");
        context.say(std::to_string(info.boundary_edges) + " boundary edges, " +
                    std::to_string(info.non_manifold_edges) + " non-manifold edges, Euler number " +
                    std::to_string(info.euler) + ", " + std::to_string(info.degenerate_triangles) +
                    " degenerate triangles");
        context.say("area " + std::to_string(info.area_mm2) + " mm2, volume " +
                    std::to_string(info.volume_mm3) + " mm3" + (info.closed ? "" : " (open)"));
        JsonResult json;
        json.set("vertices", info.vertices)
            .set("referenced_vertices", info.referenced_vertices)
            .set("triangles", info.triangles)
            .set("components", info.components)
            .set("boundary_edges", info.boundary_edges)
            .set("non_manifold_edges", info.non_manifold_edges)
            .set("euler", static_cast<int>(info.euler))
            .set("area_mm2", info.area_mm2)
            .set("volume_mm3", info.volume_mm3)
            .set("closed", info.closed)
            .set("degenerate_triangles", info.degenerate_triangles);
        context.finish(json);
        return 0;
    }

  private:
    std::string in_;
};

}  // namespace

std::unique_ptr<Verb> make_mesh_info_verb() { return std::make_unique<MeshInfoVerb>(); }

}  // namespace stria

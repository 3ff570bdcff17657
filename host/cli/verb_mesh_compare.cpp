#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/io/mesh_io.h"
#include "host/mesh/compare.h"

namespace stria {
namespace {

JsonResult to_json(const DistanceFigures& figures) {
    JsonResult json;
    json.set("samples", figures.samples)
        .set("mean_mm", figures.mean_mm)
        .set("rms_mm", figures.rms_mm)
        .set("p95_mm", figures.p95_mm)
        .set("p99_mm", figures.p99_mm)
        .set("max_mm", figures.max_mm);
    return json;
}

class MeshCompareVerb : public Verb {
  public:
    std::string name() const override { return "mesh compare"; }
    std::string summary() const override { return "distances between two meshes, both ways"; }

    void declare(Arguments& arguments) override {
        arguments.positional("A", a_, "mesh: PLY, OBJ, STL, OFF");
        arguments.positional("B", b_, "mesh: PLY, OBJ, STL, OFF");
        arguments.option("--samples", samples_,
                         "points spread evenly over each surface; 0: the vertices");
    }

    int run(const Context& context) override {
        if (samples_ < 0) throw Error("--samples: expected 0 or more");
        const TriMesh a = read_surface(a_, context), b = read_surface(b_, context);
        const MeshComparison result = compare_meshes(a, b,
                                                     {.samples = static_cast<std::size_t>(samples_),
                                                      .seed = context.seed,
                                                      .use_a = {},
                                                      .use_b = {}});
        say(context, "A to B", result.a_to_b);
        say(context, "B to A", result.b_to_a);
        context.say("Hausdorff distance " + std::to_string(result.hausdorff_mm) + " mm");
        JsonResult json;
        json.set("a_to_b", to_json(result.a_to_b))
            .set("b_to_a", to_json(result.b_to_a))
            .set("hausdorff_mm", result.hausdorff_mm);
        context.finish(json);
        return 0;
    }

  private:
    static TriMesh read_surface(const std::string& path, const Context& context) {
        TriMesh mesh = read_mesh(path, {.mm_per_unit = context.mm_per_unit()});
        if (mesh.triangles.empty())
            throw FileError(path, "", "expected a mesh with triangles, found points alone");
        return mesh;
    }

    static void say(const Context& context, const std::string& way,
                    const DistanceFigures& figures) {
        context.say(way + ": mean " + std::to_string(figures.mean_mm) + ", rms " +
                    std::to_string(figures.rms_mm) + ", 95 % " + std::to_string(figures.p95_mm) +
                    ", 99 % " + std::to_string(figures.p99_mm) + ", max " +
                    std::to_string(figures.max_mm) + " mm over " + std::to_string(figures.samples) +
                    " points");
    }

    std::string a_, b_;
    int samples_ = 0;
};

}  // namespace

std::unique_ptr<Verb> make_mesh_compare_verb() { return std::make_unique<MeshCompareVerb>(); }

}  // namespace stria

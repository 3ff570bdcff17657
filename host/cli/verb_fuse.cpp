#include <sys/resource.h>

#include "host/cli/scan_input.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/fusion/fuse.h"
#include "host/io/mesh_io.h"
#include "host/io/model_io.h"
#include "host/mesh/mesh_info.h"

namespace stria {
namespace {

double peak_rss_mb() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<double>(usage.ru_maxrss) / 1024;  // KiB on Linux
}

class FuseVerb : public Verb {
  public:
    std::string name() const override { return "fuse"; }
    std::string summary() const override { return "merge range images into one mesh"; }

    void declare(Arguments& arguments) override {
        arguments.positional("SCAN", scans_, "range PLYs, scan folders or projects");
        arguments.option("--poses", poses_,
                         "poses.toml, .conf or a 4x4 matrix; none: all scans stand in the world");
        arguments.option("--out", out_, "mesh to write: PLY, OBJ, STL, OFF, GLB", true);
        arguments.option("--voxel", options_.voxel_mm,
                         "side of a voxel, mm; 0: median pitch of the scans");
        arguments.option("--ramp", options_.ramp_mm,
                         "carving ends so far (mm) in front of the surface; 0: 2 voxels");
        arguments.option("--max-edge", options_.max_edge_mm,
                         "longer range edges (mm) are no surface; 0: 4 x the scan's pitch");
        arguments.option("--memory", memory_mb_, "most memory of the volume, MB");
        arguments.flag("--fill-holes", options_.fill_holes,
                       "close the mesh along the border of seen empty space");
        arguments.flag("--no-carve", no_carve_, "do not keep what was seen to be empty");
        arguments.flag("--carve-background", options_.carve_background,
                       "cells without return are empty as far as the volume goes");
    }

    int run(const Context& context) override {
        options_.carve = !no_carve_;
        if (memory_mb_ < 1) throw Error("--memory: expected at least 1 MB");
        options_.memory_mb = static_cast<std::size_t>(memory_mb_);
        if (const std::string wrong = options_.validate(); !wrong.empty()) throw Error(wrong);
        context.check_output(out_);
        const std::vector<ScanInput> inputs = read_range_scans(scans_, context);
        const FuseResult result = fuse(placed(inputs, context), options_);
        write_mesh(out_, result.mesh);
        report(context, result);
        return 0;
    }

  private:
    std::vector<FuseScan> placed(const std::vector<ScanInput>& inputs,
                                 const Context& context) const {
        std::vector<ScanPose> poses;
        if (!poses_.empty()) poses = read_poses(poses_, context.mm_per_unit());
        std::vector<FuseScan> placed;
        for (const ScanInput& input : inputs) {
            FuseScan scan = {.image = &input.image, .world_from_scan = {}};
            if (!poses_.empty())
                scan.world_from_scan = find_pose(poses, input.source.range).world_from_scan;
            placed.push_back(scan);
        }
        return placed;
    }

    void report(const Context& context, const FuseResult& result) const {
        const MeshInfo info = mesh_info(result.mesh);
        context.say("voxel " + std::to_string(result.voxel_mm) + " mm, ramp " +
                    std::to_string(result.ramp_mm) + " mm, " + std::to_string(result.points) +
                    " points");
        context.say(out_ + ": " + std::to_string(info.triangles) + " triangles, " +
                    std::to_string(info.boundary_edges) + " boundary edges, " +
                    std::to_string(info.components) + " components");
        JsonResult seconds;
        seconds.set("integrate", result.cpu_seconds.integrate)
            .set("carve", result.cpu_seconds.carve)
            .set("extract", result.cpu_seconds.extract);
        JsonResult json;
        json.set("voxel_mm", result.voxel_mm)
            .set("ramp_mm", result.ramp_mm)
            .set("points", result.points)
            .set("vertices", info.vertices)
            .set("triangles", info.triangles)
            .set("components", info.components)
            .set("boundary_edges", info.boundary_edges)
            .set("non_manifold_edges", info.non_manifold_edges)
            .set("cpu_seconds", seconds)
            .set("volume_mb", static_cast<double>(result.volume_bytes) / (1 << 20))
            .set("peak_rss_mb", peak_rss_mb());
        context.finish(json);
    }

    std::vector<std::string> scans_;
    std::string poses_, out_;
    FuseOptions options_;
    int memory_mb_ = 4096;
    bool no_carve_ = false;
};

}  // namespace

std::unique_ptr<Verb> make_fuse_verb() { return std::make_unique<FuseVerb>(); }

}  // namespace stria

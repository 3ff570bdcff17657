#include <ctime>

#include "host/cli/command.h"
#include "host/cli/progress.h"
#include "host/cli/scan_input.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/project/project.h"
#include "host/registration/coarse.h"
#include "host/registration/joint.h"

namespace stria {
namespace {

std::vector<double> row_by_row(const Rigid3& pose) {
    std::vector<double> values;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) values.push_back(pose.rotation(row, column));
        values.push_back(pose.translation[row]);
    }
    values.insert(values.end(), {0, 0, 0, 1});
    return values;
}

class Register final : public Verb {
  public:
    std::string name() const override { return "register"; }
    std::string summary() const override { return "find the poses that make scans fit each other"; }
    void declare(Arguments& arguments) override {
        arguments.positional("scan", scans_, "range PLYs, scan folders or projects");
        arguments.option("--poses", poses_,
                         "poses to start from (poses.toml, .conf, 4x4 text); without it the scans "
                         "are placed by their shape alone");
        arguments.option("--out", out_, "poses.toml to write", true);
    }
    int run(const Context& context) override {
        context.check_output(out_);
        const std::clock_t start = std::clock();  // of all threads
        const std::vector<ScanSource> sources = resolve_scans(scans_);
        const std::vector<ScanSurface> surfaces = read_surfaces(sources, context);
        JointOptions options;
        std::vector<ScanPose> poses =
            poses_.empty() ? placed(surfaces, sources, context, options) : given(sources, context);
        const JointResult result = register_jointly(surfaces, poses, options);
        for (std::size_t i = 0; i < poses.size(); ++i) {
            poses[i].file = relative_name(sources[i].range, out_);
            poses[i].world_from_scan = result.scans[i].world_from_scan;
            poses[i].covariance = result.scans[i].covariance;
            poses[i].fixed = result.scans[i].fixed;
        }
        if (result.converged) write_poses(out_, poses);
        report(context, sources, result,
               static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
        if (!result.converged)
            throw Error("registration failed, no poses written: " + named(result.reason, sources));
        return 0;
    }

  private:
    static std::vector<ScanSurface> read_surfaces(const std::vector<ScanSource>& sources,
                                                  const Context& context) {
        std::vector<ScanSurface> surfaces;
        Progress progress(context, "read", sources.size(), "scans");
        for (const ScanSource& source : sources) {
            surfaces.push_back(prepare_surface(read_range_scan(source, context)));
            if (surfaces.back().samples.empty())
                throw FileError(source.range, "",
                                "expected a surface of neighbouring points, found none");
            progress.update(surfaces.size());
        }
        return surfaces;
    }

    std::vector<ScanPose> given(const std::vector<ScanSource>& sources,
                                const Context& context) const {
        const std::vector<ScanPose> known = read_poses(poses_, context.mm_per_unit());
        std::vector<ScanPose> poses;
        for (const ScanSource& source : sources) poses.push_back(find_pose(known, source.range));
        return poses;
    }

    static std::vector<ScanPose> placed(const std::vector<ScanSurface>& surfaces,
                                        const std::vector<ScanSource>& sources,
                                        const Context& context, JointOptions& options) {
        const CoarseResult coarse = place_scans(surfaces);
        options.start_distance_mm = 2 * coarse.detail_mm;
        std::vector<ScanPose> poses;
        for (std::size_t i = 0; i < coarse.scans.size(); ++i) {
            if (!coarse.scans[i].placed)
                throw Error(sources[i].name + " cannot be placed: " + coarse.scans[i].reason +
                            "; give starting poses with --poses, or scan so that neighbours "
                            "overlap by half");
            poses.emplace_back();
            poses.back().world_from_scan = coarse.scans[i].world_from_scan;
        }
        context.say("placed " + std::to_string(poses.size()) + " scans by their shape");
        return poses;
    }

    /// "scan 3 ..." as the library says it, with the file beside the number.
    static std::string named(const std::string& reason, const std::vector<ScanSource>& sources) {
        constexpr std::size_t kPrefix = 5;  // "scan "
        if (reason.compare(0, kPrefix, "scan ") != 0) return reason;
        const std::size_t index = std::stoul(reason.substr(kPrefix));
        return index < sources.size() ? reason + " (" + sources[index].name + ")" : reason;
    }

    static void report(const Context& context, const std::vector<ScanSource>& sources,
                       const JointResult& result, double cpu_seconds) {
        std::vector<JsonResult> scans;
        for (std::size_t i = 0; i < sources.size(); ++i) {
            const JointScan& scan = result.scans[i];
            scans.push_back(JsonResult()
                                .set("file", sources[i].name)
                                .set("world_from_scan", row_by_row(scan.world_from_scan))
                                .set("sigma_rad", scan.sigma_rad)
                                .set("sigma_mm", scan.sigma_mm)
                                .set("matches", scan.matches)
                                .set("open_directions", scan.open_directions));
            context.say(sources[i].name + ": " + std::to_string(scan.matches) + " matches, sigma " +
                        std::to_string(scan.sigma_mm) + " mm, " + std::to_string(scan.sigma_rad) +
                        " rad" + (scan.fixed ? " (stays)" : ""));
        }
        context.say("overlap rms " + std::to_string(result.overlap_rms_mm) + " mm after " +
                    std::to_string(result.iterations) + " steps");
        context.finish(JsonResult()
                           .set("converged", result.converged)
                           .set("overlap_rms_mm", result.overlap_rms_mm)
                           .set("iterations", result.iterations)
                           .set("scans", scans)
                           .set("cpu_seconds", cpu_seconds));
    }

    std::vector<std::string> scans_;
    std::string poses_, out_;
};

}  // namespace

std::unique_ptr<Verb> make_register_verb() { return std::make_unique<Register>(); }

}  // namespace stria

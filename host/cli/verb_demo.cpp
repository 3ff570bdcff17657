#include <cstdio>
#include <filesystem>

#include "host/cli/demo/demo_report.h"
#include "host/cli/demo/demo_run.h"
#include "host/cli/verbs.h"

namespace stria {
namespace {

JsonResult figures(const ErrorFigures& f) {
    return JsonResult()
        .set("count", f.count)
        .set("mean_mm", f.mean_mm)
        .set("rms_mm", f.rms_mm)
        .set("p99_mm", f.p99_mm)
        .set("max_mm", f.max_mm);
}

std::string line(const char* format, double a, double b = 0, double c = 0) {
    char text[160];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
}

class DemoVerb final : public Verb {
  public:
    std::string name() const override { return "demo"; }
    std::string summary() const override {
        return "the whole job on the simulator: calibrate, scan, register, fuse, compare, report";
    }
    void declare(Arguments& arguments) override {
        arguments.option("--out", options_.folder, "folder for everything it makes");
        arguments.flag("--quick", options_.quick, "a smaller camera and fewer views");
        arguments.flag("--fast", options_.fast,
                       "the scanner's SIMD kernels analyse the sweeps (feature FastSpacetime)");
    }

    int run(const Context& context) override {
        context.check_output(options_.folder);
        const DemoResult result = run_demo(context, options_);
        const std::string report = options_.folder + "/part/report.html";
        write_demo_report(report, result, context.seed);
        say(context, result);
        context.say("report: " + std::filesystem::absolute(report).string());
        context.finish(json(result, report));
        return 0;
    }

  private:
    static void say(const Context& context, const DemoResult& r) {
        for (const std::string& warning : r.calibration_warnings)
            context.say("calibration: " + warning);
        context.say(line("calibration: %.3f px rms, points %.4f mm rms from the true scanner's",
                         r.calibration_rms_px, r.calibration_point_rms_mm));
        context.say(line("points: predicted sigma %.4f mm (median), actual / predicted %.3f",
                         r.median_sigma_mm, r.sigma_ratio));
        context.say(
            line("mesh error: smooth parts %.4f mm rms, all %.4f mm rms, 99 %% below %.3f mm",
                 r.truth.smooth.rms_mm, r.truth.all.rms_mm, r.truth.all.p99_mm));
        context.say(line("total: %.1f s", r.clock.total_seconds()));
    }

    static JsonResult json(const DemoResult& r, const std::string& report) {
        JsonResult seconds, memory;
        for (const StageCost& stage : r.clock.stages()) {
            seconds.set(stage.name, stage.seconds);
            memory.set(stage.name, stage.peak_rss_mb);
        }
        seconds.set("total", r.clock.total_seconds());
        const std::vector<double>&turn = r.pose_error_rad, &shift = r.pose_error_mm;
        return JsonResult()
            .set("mesh_error", figures(r.truth.all))
            .set("mesh_error_smooth", figures(r.truth.smooth))
            .set("mesh_to_truth", figures(r.truth.mesh_to_truth))
            .set("truth_to_mesh", figures(r.truth.truth_to_mesh))
            .set("filled_error", figures(r.filled))
            .set("sigma_ratio", r.sigma_ratio)
            .set("median_sigma_mm", r.median_sigma_mm)
            .set("calibration_rms_px", r.calibration_rms_px)
            .set("calibration_point_rms_mm", r.calibration_point_rms_mm)
            .set("calibration_diagonal_mm", r.calibration_diagonal_mm)
            .set("overlap_rms_mm", r.overlap_rms_mm)
            .set("pose_error_rad", turn)
            .set("pose_error_mm", shift)
            .set("scans", r.scans.size())
            .set("voxel_mm", r.voxel_mm)
            .set("triangles", r.filled_mesh.triangles.size())
            .set("seconds", seconds)
            .set("peak_rss_mb", memory)
            .set("report", report);
    }

    DemoOptions options_{.folder = "stria-demo"};
};

}  // namespace

std::unique_ptr<Verb> make_demo_verb() { return std::make_unique<DemoVerb>(); }

}  // namespace stria

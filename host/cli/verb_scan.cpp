#include <cmath>
#include <cstdio>
#include <filesystem>

#include "host/cli/default_plan.h"
#include "host/cli/drift_check.h"
#include "host/cli/fast_analysis.h"
#include "host/cli/progress.h"
#include "host/cli/recording_range.h"
#include "host/cli/temperature_option.h"
#include "host/cli/today.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/core/short_number.h"
#include "host/geometry/parallel.h"
#include "host/io/certificate.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "host/local/open_device.h"
#include "host/project/project.h"

namespace stria {
namespace {

constexpr double kMostWarmerC = 5;  ///< than at the calibration, or colder

class ScanVerb final : public Verb {
  public:
    std::string name() const override { return "scan"; }
    std::string summary() const override { return "one scan into a project"; }
    void declare(Arguments& arguments) override {
        arguments.positional("DEVICE", device_,
                             "sim:SCENE.toml, unix:PATH, tcp:HOST:PORT or replay:FILE");
        arguments.option("--out", out_, "project folder; made if it does not exist", true);
        arguments.option("--plan", plan_, "plan.toml; without it the axis' whole travel");
        arguments.option("--model", model_,
                         "calibrated scanner; without it the project's scanner.toml");
        arguments.option("--view", view_, "simulated devices: which placement of the objects");
        temperature_.declare(arguments, "of the scanner now, degrees Celsius, for scan.toml");
        check_.declare(arguments);
        arguments.flag("--fast", fast_,
                       "the device's SIMD kernels analyse the sweep (feature FastSpacetime)");
    }

    int run(const Context& context) override {
        const std::optional<double> temperature_c = temperature_.value();
        check_.read();
        OpenOptions open;
        open.seed = context.seed;
        open.threads = thread_count();
        auto device = open_device(device_, open);
        if (view_ >= 0) device->set_feature("SceneView", FeatureValue(std::int64_t{view_}));
        const Snapshot info = device->info();
        const ScanPlan plan = plan_.empty() ? default_plan(info) : read_plan(plan_);
        if (fast_) ask_for_fast_analysis(*device, plan);
        const Project project = open_or_create_project(out_);
        const std::string model_path = keep_model(context, project);
        if (check_.is_asked() && model_path.empty())
            throw Error(
                "--check: expected a project with scanner.toml, or --model: without a "
                "calibration there is no range image to check");
        if (check_.becomes_reference()) context.check_output(project.check());
        send_paths(context, *device, info, plan, model_path);
        const ScanFolder folder = make_next_scan(project);

        const RecordingContents recording = record(context, *device, plan, folder);
        JsonResult result;
        result.set("scan", folder.folder).set("recording", folder.recording());
        for (const std::string& note : recording.notes) context.say(note);
        if (!recording.end || !recording.end->complete) {
            result.set("complete", false);
            context.finish(result);
            throw Error("the sweep ended early: " +
                        (recording.end ? recording.end->reason : std::string("no end came")) +
                        "; what came is in " + folder.recording());
        }
        result.set("complete", true)
            .set("fast", was_fast_analysis(recording.snapshot))
            .set("frames", static_cast<int>(recording.end->frames))
            .set("frames_dropped", static_cast<int>(recording.end->frames_dropped));
        ScanNotes notes;
        notes.temperature_c = temperature_c;
        if (model_path.empty()) {
            context.say(
                folder.recording() +
                ": recorded. No calibration is known, so there is no range image: run stria "
                "calibrate scanner, then stria range with its --model");
        } else {
            const ScannerModel model = read_scanner(model_path);
            warn(context, read_certificate(model_path), model, temperature_c, result);
            if (const std::string note = paths_note(recording, model); !note.empty())
                context.say(folder.recording() + ": " + note);
            const RangeResult range = range_of(recording, model, folder.recording());
            write_range_image(folder.range(), range.image);
            context.say(folder.range() + ": " + describe(range.statistics));
            for (const std::string& note : range.notes) context.say(folder.range() + ": " + note);
            result.set("range", folder.range())
                .set("points", range.statistics.points)
                .set("median_sigma_mm", range.statistics.median_sigma_mm);
            notes.model_hash = range.image.model_hash;
            write_whole_file(folder.notes(), format_scan_notes(notes));  // whatever the check finds
            if (check_.is_asked()) check_.run(context, range.image, project.check(), notes, result);
        }
        write_whole_file(folder.notes(), format_scan_notes(notes));
        context.finish(result);
        return 0;
    }

  private:
    /// What a user of the calibration should hear.
    static void warn(const Context& context, const std::optional<Certificate>& certificate,
                     const ScannerModel& model, const std::optional<double>& temperature_c,
                     JsonResult& result) {
        if (const std::string why = certificate_warning(certificate, model, today());
            !why.empty()) {
            context.say("warning: " + why);
            result.set("certificate_warning", why);
        }
        if (certificate && certificate->temperature_c && temperature_c &&
            std::abs(*temperature_c - *certificate->temperature_c) > kMostWarmerC)
            context.say("warning: calibrated at " + short_number(*certificate->temperature_c, 4) +
                        " degrees Celsius, now at " + short_number(*temperature_c, 4) +
                        ": frames of aluminium and lenses move by 5 to 50 um per metre and degree; "
                        "--check with a sphere or plane in view tells what that makes");
    }

    /// The project's model; --model becomes it. Empty: there is none.
    std::string keep_model(const Context& context, const Project& project) const {
        const std::string kept = project.scanner();
        if (model_.empty()) return std::filesystem::exists(kept) ? kept : "";
        const ScannerModel model = read_scanner(model_);
        if (std::filesystem::exists(kept) &&
            format_scanner(read_scanner(kept)) != format_scanner(model))
            context.check_output(kept);
        write_scanner(kept, model, read_certificate(model_));
        return kept;
    }

    /// A rail or turntable measures pulses in spacetime along the paths of its calibration.
    void send_paths(const Context& context, DeviceClient& device, const Snapshot& info,
                    const ScanPlan& plan, const std::string& model_path) const {
        if (info.device.kind == name_of(MachineKind::swept) || plan.record == RecordWhat::frames)
            return;
        if (plan.mode == StripeMode::spacetime && model_path.empty())
            throw Error("mode = spacetime: a " + info.device.kind +
                        " measures pulses along the image paths of its calibration, and none is "
                        "known: expected a project with scanner.toml or --model, or in the plan "
                        "mode = \"spatial\" or record = \"frames\"");
        if (plan.mode == StripeMode::spacetime)
            device.set_paths(paths_for(read_scanner(model_path), plan.lasers));
        else if (plan_.empty())
            context.say(
                "spatial peaks: without --plan the steps may exceed the beam's width; a plan with "
                "mode = \"spacetime\" measures pulses along the calibration's image paths");
    }

    static RecordingContents record(const Context& context, DeviceClient& device,
                                    const ScanPlan& plan, const ScanFolder& folder) {
        const auto frames = static_cast<std::size_t>(std::ceil((plan.to - plan.from) / plan.step)) *
                            (plan.both_directions ? 2U : 1U);
        Progress progress(context, "scanning", frames, "frames");
        RunOptions options;
        options.recording_path = folder.recording();
        if (plan.record != RecordWhat::frames) options.load.on_frame = [](const Frame&) {};
        options.progress = [&](const RunProgress& run) { progress.update(run.frames); };
        return device.run(plan, options);
    }

    std::string device_, out_, plan_, model_;
    int view_ = -1;
    TemperatureOption temperature_;
    DriftCheck check_;
    bool fast_ = false;
};

}  // namespace

std::unique_ptr<Verb> make_scan_verb() { return std::make_unique<ScanVerb>(); }

}  // namespace stria

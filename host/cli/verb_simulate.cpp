#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "firmware/core/median.h"
#include "host/cli/fast_analysis.h"
#include "host/cli/progress.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/core/frame_image.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "host/local/local_scanner.h"

namespace stria {
namespace {

/// Frames a beam standard deviation for each preset.
double frames_per_sigma(const std::string& preset) {
    return preset == "fast" ? 0.7 : preset == "fine" ? 2.0 : 1.2;
}

/// Median axis travel that moves the sheet by one standard deviation over the part: on a swept
/// machine over the surface, on others the distance the surface itself goes.
double axis_travel_of_a_sigma(const SimulatedScanner& scanner) {
    const Channel channel = scanner.truth_model().channels.front();
    const SceneAxis& axis = scanner.scene().axis;
    const double middle = (axis.min + axis.max) / 2;
    const std::vector<double> once = {middle};
    const RangeImage truth = scanner.true_range(once);
    std::vector<double> travels;
    const std::size_t stride = std::max<std::size_t>(1, truth.cell_count() / 4000);
    for (std::size_t i = 0; i < truth.cell_count(); i += stride) {
        if (truth.mask[i] == 0) continue;
        const RangePoint& point = truth.points[i];
        const Eigen::Vector3d p = scan_from_camera(channel, point.s).inverse() * point.position;
        const double sigma_mm = sigma_at(sheet_at(channel, point.s), p);
        double mm_per_s = 1;  // rail
        if (channel.axis.kind == MachineKind::turntable)
            mm_per_s = std::max(5.0, point.position.head<2>().norm());
        if (channel.axis.kind == MachineKind::swept) {
            const double h = 1e-5;
            mm_per_s = std::abs(signed_distance(sheet_at(channel, point.s + h), p) -
                                signed_distance(sheet_at(channel, point.s - h), p)) /
                       (2 * h);
        }
        travels.push_back(sigma_mm / mm_per_s);
    }
    if (travels.empty())
        throw Error("simulate: at s = " + std::to_string(middle) +
                    " the laser meets nothing that the camera sees; state --plan");
    return median(std::move(travels));
}

std::string numbered(const char* stem, std::size_t number) {
    char name[40];
    std::snprintf(name, sizeof name, "%s_%05zu.png", stem, number);
    return name;
}

class SimulateVerb final : public Verb {
  public:
    std::string name() const override { return "simulate"; }
    std::string summary() const override {
        return "scan a scene with the simulated scanner: images, recording and the truth";
    }

    void declare(Arguments& arguments) override {
        arguments.positional("SCENE", scene_, "scene.toml");
        arguments.option("--out", out_, "folder to write into", true);
        arguments.flag("--frames", frames_, "record the frames too, and write them as PNG");
        arguments.choice("--preset", preset_, {"fast", "standard", "fine"},
                         "frames while the stripe moves by its standard deviation: 0.7, 1.2, 2");
        arguments.option("--plan", plan_, "plan.toml to carry out instead of a preset");
        arguments.option("--view", view_, "number of the scene's view, from 0");
        arguments.flag("--fast", fast_,
                       "the scanner's SIMD kernels analyse the sweep (feature FastSpacetime)");
    }

    int run(const Context& context) override {
        const Scene scene = read_scene(scene_);
        if (view_ < 0 || view_ >= view_count(scene))
            throw Error("--view " + std::to_string(view_) + ": expected 0 to " +
                        std::to_string(view_count(scene) - 1));
        context.check_output(path("recording.stria"));
        std::filesystem::create_directories(out_);
        OpenOptions options;
        options.seed = context.seed;
        options.threads = std::max(1, context.threads);
        LocalScanner local(scene, options);
        local.scanner().set_view(view_);
        const ScanPlan plan = make_plan(local.scanner());
        if (fast_) ask_for_fast_analysis(local, plan);

        const auto begin = std::chrono::steady_clock::now();
        const RecordingContents contents = scan(context, local, plan);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
        if (contents.end && !contents.end->complete)
            context.say("the run ended early: " + contents.end->reason);

        const RangeImage truth = local.scanner().true_range(positions(contents, plan));
        write_range_image(path("truth.ply"), truth);
        write_scanner(path("truth_scanner.toml"), local.scanner().truth_model());
        report(context, contents, plan, truth, seconds.count());
        return contents.end && contents.end->complete ? 0 : 1;
    }

  private:
    std::string path(const std::string& file) const {
        return (std::filesystem::path(out_) / file).string();
    }

    ScanPlan make_plan(const SimulatedScanner& scanner) const {
        ScanPlan plan;
        const Scene& scene = scanner.scene();
        if (!plan_.empty()) {
            plan = read_plan(plan_);
        } else {
            const bool swept = scene.channel.axis.kind == MachineKind::swept;
            plan.mode = swept ? StripeMode::spacetime : StripeMode::spatial;
            plan.from = scene.axis.min;
            plan.to = scene.axis.max;
            plan.step = axis_travel_of_a_sigma(scanner) / frames_per_sigma(preset_);
        }
        if (plan.exposures_us.empty()) plan.exposures_us = {scene.sensor.exposure_us};
        if (frames_) plan.record = RecordWhat::both;
        return plan;
    }

    /// Runs the plan; with --frames writes the images and times.txt on the way.
    RecordingContents scan(const Context& context, LocalScanner& local, const ScanPlan& plan) {
        std::optional<Progress> progress;
        RunOptions options;
        options.recording_path = path("recording.stria");
        options.load.on_frame = [&](const Frame& frame) {
            if (frames_) write_frame(frame, numbered("frame", frame_s_.size()));
            frame_s_.push_back(
                local.scanner().true_axis_position(frame.row_time(frame.height / 2)));
        };
        options.progress = [&](const RunProgress& run) {
            if (!progress) progress.emplace(context, "simulate", run.frames_expected, "frames");
            progress->update(run.frames);
        };
        RecordingContents contents = local.run(plan, options);
        for (std::size_t i = 0; frames_ && i < contents.off_frames.size(); ++i)
            write_frame(contents.off_frames[i], numbered("off", i));
        if (frames_) {
            std::string times;
            char line[40];
            for (double s : frame_s_) {
                std::snprintf(line, sizeof line, "%.12g\n", s);
                times += line;
            }
            write_whole_file(path("times.txt"), times);
        }
        true_s_of_ = [&local](TimeNs time) { return local.scanner().true_axis_position(time); };
        return contents;
    }

    void write_frame(const Frame& frame, const std::string& file) const {
        if (frame.bits == 8) {
            GreyImage image(frame.width, frame.height);
            std::copy(frame.bytes.begin(), frame.bytes.end(), image.values.begin());
            write_png(path(file), image);
            return;
        }
        write_png(path(file), image_from_frame(frame));  // as the sensor counts, not stretched
    }

    /// Axis position of every frame of the first sweep: from the frames, or where only pulses were
    /// recorded from any pulse of a spatial map, whose columns are frames a step apart.
    std::vector<double> positions(const RecordingContents& contents, const ScanPlan& plan) const {
        if (!frame_s_.empty()) return frame_s_;
        std::vector<double> s;
        if (contents.pulse_maps.empty() || contents.pulse_maps.front().mode != StripeMode::spatial)
            return s;
        const PulseMap& map = contents.pulse_maps.front();
        for (int y = 0; y < map.height && s.empty(); ++y) {
            for (int x = 0; x < map.width && s.empty(); ++x) {
                if (map.cell(x, y).empty()) continue;
                const double at = true_s_of_(map.cell(x, y).front().t_ns);
                for (int k = 0; k < map.width; ++k) s.push_back(at + (k - x) * plan.step);
            }
        }
        return s;
    }

    void report(const Context& context, const RecordingContents& contents, const ScanPlan& plan,
                const RangeImage& truth, double seconds) const {
        std::size_t pulses = 0, saturated = 0, frames = frame_s_.size();
        for (const PulseMap& map : contents.pulse_maps) {
            pulses += map.pulses.size();
            saturated += map.saturated_samples;
            if (!frames_) frames += map.frames;
        }
        const double rate = static_cast<double>(frames) / seconds;
        char line[200];
        std::snprintf(line, sizeof line,
                      "%zu frames, step %.4g, %.1f frames/s; %zu pulses; truth has %zu points",
                      frames, plan.step, rate, pulses, valid_count(truth));
        context.say(line);
        JsonResult result;
        result.set("frames", frames)
            .set("images", frames_ ? frames + contents.off_frames.size() : std::size_t{0})
            .set("from", plan.from)
            .set("to", plan.to)
            .set("step", plan.step)
            .set("pulses", pulses)
            .set("saturated_samples", saturated)
            .set("truth_points", valid_count(truth))
            .set("frames_per_second", rate)
            .set("recording", path("recording.stria"))
            .set("truth", path("truth.ply"));
        context.finish(result);
    }

    std::string scene_, out_, preset_ = "standard", plan_;
    int view_ = 0;
    bool fast_ = false;
    bool frames_ = false;
    std::vector<double> frame_s_;
    std::function<double(TimeNs)> true_s_of_;
};

}  // namespace

std::unique_ptr<Verb> make_simulate_verb() { return std::make_unique<SimulateVerb>(); }

}  // namespace stria

#include "host/cli/board_capture.h"

#include <algorithm>
#include <iostream>
#include <optional>

#include "calib/coach.h"
#include "firmware/protocol/crc32c.h"
#include "host/cli/calibration_views.h"
#include "host/cli/progress.h"
#include "host/core/errors.h"
#include "host/geometry/parallel.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "host/local/local_scanner.h"

namespace stria {
namespace {

constexpr std::size_t kLeastForCheck = 10;  ///< views; fewer all solve

std::uint32_t check_sum(const CalibrationView& view) {
    std::uint32_t crc = 0;
    const auto add = [&](const void* data, std::size_t size) {
        crc = crc32c({static_cast<const std::uint8_t*>(data), size}, crc);
    };
    for (const BoardImage& image : view.images) {
        add(image.image.values.data(), image.image.values.size());
        add(&image.s, sizeof image.s);
    }
    const auto add_pulses = [&](const PulseMap& pass) {
        for (const Pulse& pulse : pass.pulses) {
            const double numbers[] = {pulse.u, pulse.v, pulse.s};
            add(numbers, sizeof numbers);
        }
    };
    add_pulses(view.pulses);
    for (const PulseMap& pass : view.further_passes) add_pulses(pass);
    return crc;
}

OpenOptions open_options(const Context& context, int view) {
    OpenOptions open;
    open.seed = context.seed + static_cast<unsigned>(view);
    open.threads = thread_count();
    return open;
}

/// Waits until the person has placed the board.
void wait_for_enter(int view, int views, const std::string& where) {
    std::cerr << "view " << view + 1 << " of " << views << ": "
              << (where.empty() ? "place the board" : where) << ", let it rest and press Enter\n";
    std::string line;
    if (!std::getline(std::cin, line))
        throw Error("input ended while waiting for the board of view " + std::to_string(view + 1));
}

RecordingContents sweep(DeviceClient& device, const ScanPlan& plan) {
    RunOptions options;
    if (plan.record != RecordWhat::frames) options.load.on_frame = [](const Frame&) {};
    return device.run(plan, options);
}

/// The one object with a texture: the board.
const SceneObject& board_of(const Scene& scene, const std::string& name) {
    const SceneObject* found = nullptr;
    for (const SceneObject& object : scene.objects) {
        if (!object.texture_image) continue;
        if (found)
            throw Error(name + ": objects '" + found->name + "' and '" + object.name +
                        "' both have a texture; expected one, the board");
        found = &object;
    }
    if (!found)
        throw Error(name +
                    ": no object has a texture; expected the board's picture on one (stria "
                    "calibrate board draws it)");
    return *found;
}

/// The scene with its board there and nothing else.
Scene with_board_at(const Scene& scene, const std::string& name, const Rigid3& world_from_board) {
    const SceneObject& board = board_of(scene, name);
    Scene placed = scene;
    SceneView view;
    view.name = "guided";
    view.poses.push_back({board.name, world_from_board});
    for (const SceneObject& object : scene.objects)
        if (object.name != board.name) view.hidden.push_back(object.name);
    placed.views = {view};
    return placed;
}

CoachOptions coach_options(const ScanPlan& plan) {
    CoachOptions options;
    options.mode = plan.mode;
    options.plan.sweep_from = plan.from;
    options.plan.sweep_to = plan.to;
    options.plan.picture_s.clear();
    for (int i = 0; i < plan.off_frames; ++i)
        options.plan.picture_s.push_back(
            i == 0 ? plan.from : plan.from + (plan.to - plan.from) * i / (plan.off_frames - 1));
    return options;
}

/// A device that is asked for view after view, real or simulated.
class GuidedDevice {
  public:
    GuidedDevice(const Context& context, const BoardCaptureOptions& options)
        : context_(context), options_(options) {
        if (options.device.starts_with("sim:")) {
            const std::string path = options.device.substr(4);
            scene_ = path.empty() ? built_in_scene() : read_scene(path);
            board_of(*scene_, options.device);
            device_ = std::make_unique<LocalScanner>(*scene_, open_options(context, 0));
        } else {
            device_ = open_device(options.device, open_options(context, 0));
        }
    }
    Snapshot info() { return device_->info(); }

    /// @param wanted  the advice as told to the person
    RecordingContents take(int view, const CoachAdvice& advice, const std::string& wanted,
                           const ScannerModel& nominal) {
        if (scene_) {
            const Rigid3 world_from_board =
                scan_from_camera(nominal.channels.front(), 0) * advice.camera_from_board;
            device_ = std::make_unique<LocalScanner>(
                with_board_at(*scene_, options_.device, world_from_board),
                open_options(context_, view));
        } else {
            wait_for_enter(view, options_.views, wanted);
        }
        return sweep(*device_, options_.plan);
    }

  private:
    const Context& context_;
    const BoardCaptureOptions& options_;
    std::optional<Scene> scene_;
    std::unique_ptr<DeviceClient> device_;
};

void capture_guided(const Context& context, const Board& board, const BoardCaptureOptions& options,
                    GatheredViews& gathered) {
    GuidedDevice device(context, options);
    if (!gathered.has_nominal) {
        const std::string text = device.info().model_text;
        if (text.empty())
            throw Error(options.device +
                        ": states no design model to guide by; give one with --nominal");
        gathered.nominal = parse_scanner(text, options.device);
        gathered.has_nominal = true;
    }
    Coach coach(board, gathered.nominal, coach_options(options.plan));
    int lost = 0;
    for (int view = 0; view < options.views;) {
        const CoachAdvice advice = coach.advise();
        if (!options.picture_path.empty()) {
            write_whole_file(options.picture_path, coach.picture(advice));
            if (view == 0 && lost == 0)
                context.say("where to hold the board, drawn before each view: " +
                            options.picture_path);
        }
        const std::string name = "view " + std::to_string(view + 1);
        const bool checks =
            is_held_out(static_cast<std::size_t>(view), static_cast<std::size_t>(options.views),
                        options.check_every);
        const std::string wanted =
            checks ? advice.place + ". This view is held out to check the result" : advice.text;
        context.say(name + ": " + wanted);
        add_view(gathered, device.take(view + lost, advice, wanted, gathered.nominal), board, name);
        for (const std::string& refusal : gathered.views.back().refusals) context.say(refusal);
        const CornerView& taken = gathered.views.back();
        if (checks ? coach.can_use(taken) : coach.take(taken)) {
            if (checks) coach.avoid(advice.camera_from_board);
            ++view;
            continue;
        }
        gathered.views.pop_back();
        gathered.crcs.pop_back();
        coach.avoid(advice.camera_from_board);
        context.say(name + ": no usable board or stripe in it; once more, elsewhere");
        if (++lost > options.views)
            throw Error("no usable board in " + std::to_string(lost) +
                        " views: is it the board stated, in the light, at the place asked for?");
    }
}

void capture_unguided(const Context& context, const Board& board,
                      const BoardCaptureOptions& options, GatheredViews& gathered) {
    const auto device = open_device(options.device, open_options(context, 0));
    const auto features = device->features();
    const bool has_views =
        std::any_of(features.begin(), features.end(),
                    [](const Feature& feature) { return feature.name == "SceneView"; });
    Progress progress(context, "sweeping over the board", static_cast<std::size_t>(options.views),
                      "views");
    for (int view = 0; view < options.views; ++view) {
        if (has_views)
            device->set_feature("SceneView", FeatureValue(std::int64_t{view}));
        else
            wait_for_enter(view, options.views, "");
        add_view(gathered, sweep(*device, options.plan), board, "view " + std::to_string(view + 1));
        for (const std::string& refusal : gathered.views.back().refusals) context.say(refusal);
        progress.update(static_cast<std::size_t>(view) + 1);
    }
}

}  // namespace

bool is_held_out(std::size_t i, std::size_t usable, int every) {
    const auto step = static_cast<std::size_t>(every);
    return every > 0 && usable >= kLeastForCheck && i % step == step / 2;
}

void add_view(GatheredViews& gathered, const RecordingContents& contents, const Board& board,
              const std::string& name) {
    if (!gathered.has_nominal) {
        gathered.nominal = nominal_model_of(contents, name);
        gathered.has_nominal = true;
    }
    const CalibrationView view = calibration_view_of(contents, name);
    gathered.simulated = gathered.simulated && contents.snapshot.device.simulated;
    gathered.crcs.push_back(check_sum(view));
    gathered.views.push_back(find_corners(view, board));
}

void capture_views(const Context& context, const Board& board, const BoardCaptureOptions& options,
                   GatheredViews& gathered) {
    if (options.guided)
        capture_guided(context, board, options, gathered);
    else
        capture_unguided(context, board, options, gathered);
}

}  // namespace stria

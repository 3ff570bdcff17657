#include "host/cli/demo/demo_capture.h"

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "host/core/errors.h"

namespace stria {

std::string scan_name(std::size_t index) {
    char text[16];
    std::snprintf(text, sizeof text, "%04zu", index + 1);
    return text;
}

std::vector<std::string> capture_views(
    DeviceClient& device, const ScanPlan& plan, int views, const std::string& folder,
    const std::function<void(std::size_t, std::size_t)>& on_frame) {
    const auto frames = static_cast<std::size_t>(std::ceil((plan.to - plan.from) / plan.step));
    std::vector<std::string> paths;
    for (int view = 0; view < views; ++view) {
        device.set_feature("SceneView", FeatureValue(std::int64_t{view}));
        const std::string scan = folder + "/" + scan_name(static_cast<std::size_t>(view));
        std::filesystem::create_directories(scan);
        RunOptions options;
        options.recording_path = scan + "/recording.stria";
        options.load.on_frame = [](const Frame&) {};
        options.progress = [&](const RunProgress& progress) {
            on_frame(static_cast<std::size_t>(view) * frames + progress.frames,
                     static_cast<std::size_t>(views) * frames);
        };
        const RecordingContents run = device.run(plan, options);
        if (!run.end || !run.end->complete)
            throw Error("view " + std::to_string(view + 1) + ": the sweep ended early: " +
                        (run.end ? run.end->reason : "the recording has no end"));
        paths.push_back(options.recording_path);
    }
    return paths;
}

std::vector<Frame> sample_stripe_frames(DeviceClient& device, const ScanPlan& plan, int count) {
    std::vector<Frame> frames;
    for (int i = 1; i <= count; ++i) {
        ScanPlan sample = plan;  // a short sweep at the scan's own speed, so nothing smears
        sample.record = RecordWhat::frames;
        sample.off_frames = 0;
        sample.from = plan.from + (plan.to - plan.from) * i / (count + 1);
        sample.to = sample.from + 4 * plan.step;
        const RecordingContents run = device.run(sample);
        if (!run.frames.empty()) frames.push_back(run.frames[run.frames.size() / 2]);
    }
    return frames;
}

}  // namespace stria

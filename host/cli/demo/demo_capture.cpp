#include "host/cli/demo/demo_capture.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <future>
#include <mutex>
#include <numeric>

#include "host/core/errors.h"
#include "host/geometry/parallel.h"

namespace stria {
namespace {

constexpr int kDevices = 2;  // fixed: which view follows which decides a recording's times

}  // namespace

std::string scan_name(std::size_t index) {
    char text[16];
    std::snprintf(text, sizeof text, "%04zu", index + 1);
    return text;
}

std::vector<std::string> capture_views(
    const std::function<std::unique_ptr<DeviceClient>()>& open, const ScanPlan& plan, int views,
    const std::string& folder, const std::function<void(std::size_t, std::size_t)>& on_frame) {
    const auto frames_each = static_cast<std::size_t>(std::ceil((plan.to - plan.from) / plan.step));
    std::vector<std::size_t> frames(static_cast<std::size_t>(views));
    std::vector<std::string> paths(frames.size());
    std::mutex frames_mutex;
    const auto capture_every_other = [&](int first) {
        const auto device = open();
        for (int view = first; view < views; view += kDevices) {
            const auto i = static_cast<std::size_t>(view);
            const std::string scan = folder + "/" + scan_name(i);
            std::filesystem::create_directories(scan);
            device->set_feature("SceneView", FeatureValue(std::int64_t{view}));
            RunOptions options;
            options.recording_path = scan + "/recording.stria";
            options.load.on_frame = [](const Frame&) {};
            options.progress = [&](const RunProgress& progress) {
                const std::lock_guard lock(frames_mutex);
                frames[i] = progress.frames;
                on_frame(std::accumulate(frames.begin(), frames.end(), std::size_t{0}),
                         frames.size() * frames_each);
            };
            const RecordingContents run = device->run(plan, options);
            if (!run.end || !run.end->complete)
                throw Error("view " + std::to_string(view + 1) + ": the sweep ended early: " +
                            (run.end ? run.end->reason : "the recording has no end"));
            paths[i] = options.recording_path;
        }
    };
    // Not the pool of parallel_for_blocks: these wait for their devices most of the time.
    const auto when = thread_count() > 1 ? std::launch::async : std::launch::deferred;
    std::vector<std::future<void>> devices;
    for (int first = 0; first < std::min(kDevices, views); ++first)
        devices.push_back(std::async(when, capture_every_other, first));
    for (auto& device : devices) device.wait();
    for (auto& device : devices) device.get();
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

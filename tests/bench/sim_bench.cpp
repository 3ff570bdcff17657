#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "host/geometry/parallel.h"
#include "sim/simulated_scanner.h"

/// Prints how fast the simulator makes frames, noise and 8-bit output included: the median of 200
/// frames of a sweep for each kind of machine.
/// Usage: sim_bench FOLDER_OF_SCENES
namespace stria {
namespace {

double seconds_now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

void resize_camera(CameraModel& camera, int width, int height) {
    const double scale = static_cast<double>(width) / camera.width;
    camera.fx *= scale;
    camera.fy *= scale;
    camera.cx = (width - 1) / 2.0;
    camera.cy = (height - 1) / 2.0;
    camera.width = width;
    camera.height = height;
}

int measure(Scene scene, const char* what, int width, int height) {
    resize_camera(scene.channel.camera, width, height);
    const double begin = seconds_now();
    SimulatedScanner scanner(scene, 1);
    Devices d = scanner.devices();
    const AxisInfo axis = d.axis.info();
    constexpr int kFrames = 200;
    const TimeNs period = std::max<TimeNs>(d.camera.info().min_frame_period_ns, 2 * kNsPerMs);
    const double speed = std::min(
        axis.max_speed, (axis.max_s - axis.min_s) / (kFrames * static_cast<double>(period) * 1e-9));
    const TimeNs far = 1000 * kNsPerSecond;
    Frame frame;
    const bool ready = d.camera.configure({period / 2, period}).ok() && d.laser.on(1).ok() &&
                       d.axis.move_to(axis.min_s, far).ok() &&
                       d.axis.start_sweep(axis.min_s, axis.max_s, speed).ok() &&
                       d.camera.start().ok() && d.camera.next_frame(frame, far).ok();
    if (!ready) return 1;
    const double first = seconds_now() - begin;
    std::vector<double> seconds;
    const std::clock_t busy = std::clock();
    for (int i = 0; i < kFrames; ++i) {
        const double start = seconds_now();
        if (!d.camera.next_frame(frame, far).ok()) return 1;
        seconds.push_back(seconds_now() - start);
    }
    const double cpu_ms = 1e3 * static_cast<double>(std::clock() - busy) / CLOCKS_PER_SEC / kFrames;
    std::sort(seconds.begin(), seconds.end());
    std::printf(
        "%-22s %4d x %4d  median %7.1f frames/s  (p10 %.1f, p90 %.1f)  %5.1f ms CPU a frame  ready "
        "after %.2f s\n",
        what, width, height, 1 / seconds[kFrames / 2], 1 / seconds[kFrames * 9 / 10],
        1 / seconds[kFrames / 10], cpu_ms, first);
    return 0;
}

int run(const std::string& folder) {
    std::printf("%d threads, %s build, 200 frames each, noise and 8-bit output included\n",
                thread_count(),
#ifdef NDEBUG
                "release"
#else
                "debug"
#endif
    );
    return measure(read_scene(folder + "/swept.toml"), "swept", 1280, 1024) +
           measure(read_scene(folder + "/swept.toml"), "swept, demo's size", 800, 640) +
           measure(read_scene(folder + "/rail.toml"), "rail", 640, 512) +
           measure(read_scene(folder + "/turntable.toml"), "turntable", 640, 512);
}

}  // namespace
}  // namespace stria

int main(int count, char** arguments) {
    if (count != 2) {
        std::fprintf(stderr, "usage: sim_bench FOLDER_OF_SCENES\n");
        return 2;
    }
    return stria::run(arguments[1]);
}

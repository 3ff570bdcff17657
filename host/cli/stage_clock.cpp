#include "host/cli/stage_clock.h"

#include <ctime>
#include <fstream>
#include <sstream>

namespace stria {

double process_cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double peak_rss_mb() {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
        if (line.rfind("VmHWM:", 0) == 0) {
            std::istringstream words(line.substr(6));
            double kilobytes = 0;
            words >> kilobytes;
            return kilobytes / 1024.0;
        }
    return 0;
}

void reset_peak_rss() {
    std::ofstream clear("/proc/self/clear_refs");
    clear << "5";  // Linux: proc(5), resets VmHWM
}

void StageClock::begin(const std::string& name) {
    end();
    stages_.push_back({.name = name});
    running_ = true;
    reset_peak_rss();
    wall_start_ = std::chrono::steady_clock::now();
    cpu_start_ = process_cpu_seconds();
}

void StageClock::end() {
    if (!running_) return;
    running_ = false;
    StageCost& cost = stages_.back();
    cost.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start_).count();
    cost.cpu_seconds = process_cpu_seconds() - cpu_start_;
    cost.peak_rss_mb = peak_rss_mb();
}

double StageClock::total_seconds() const {
    double sum = 0;
    for (const StageCost& stage : stages_) sum += stage.seconds;
    return sum;
}

}  // namespace stria

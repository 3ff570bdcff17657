#pragma once
#include <chrono>
#include <string>
#include <vector>

namespace stria {

/// One step of a long command, as measured.
struct StageCost {
    std::string name;
    double seconds = 0;      ///< wall
    double cpu_seconds = 0;  ///< of all threads
    double peak_rss_mb = 0;  ///< greatest resident memory during the step
};

/// Measures the steps of a command one after another.
class StageClock {
  public:
    /// Ends the step under way, if any, and begins the next.
    void begin(const std::string& name);
    void end();
    const std::vector<StageCost>& stages() const { return stages_; }
    double total_seconds() const;

  private:
    std::vector<StageCost> stages_;
    bool running_ = false;
    std::chrono::steady_clock::time_point wall_start_;
    double cpu_start_ = 0;
};

/// CPU seconds that the process has used so far, all threads.
double process_cpu_seconds();
/// Greatest resident memory since the start or the last reset_peak_rss(), MB.
double peak_rss_mb();
/// Lets peak_rss_mb() start anew; without effect where the kernel does not allow it.
void reset_peak_rss();

}  // namespace stria

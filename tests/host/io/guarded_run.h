#pragma once
#include <functional>
#include <string>

namespace stria {

/// How a piece of work ended in a process of its own.
struct GuardedResult {
    bool crashed = false;  ///< by a signal, or stopped after the time limit
    std::string message;   ///< what the work returned, or the text of its exception
    bool refused = false;  ///< it ended with a stria::Error
    double seconds = 0;
    double peak_mb = 0;  ///< greatest resident memory of the process
};

/// Runs `work` in a forked process; stops it after `limit_s`.
GuardedResult run_guarded(const std::function<std::string()>& work, double limit_s = 20.0);

/// Whether the peak is that of the work alone: sanitizers add their own memory.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kPeakIsOurs = false;
#else
constexpr bool kPeakIsOurs = true;
#endif

/// Reads a mesh, points, an image or poses by the file's ending and says what was found.
std::string describe_file(const std::string& path);

}  // namespace stria

#include "host/cli/progress.h"

#include <unistd.h>

#include <cstdio>

namespace stria {

using Seconds = std::chrono::duration<double>;

Progress::Progress(const Context& context, std::string title, std::size_t total, std::string unit)
    : visible_(!context.quiet && ::isatty(STDERR_FILENO) != 0),
      title_(std::move(title)),
      unit_(std::move(unit)),
      total_(total),
      start_(std::chrono::steady_clock::now()),
      drawn_(start_) {
    if (visible_) draw(0);
}

Progress::~Progress() {
    if (visible_) std::fprintf(stderr, "\r\033[K");
}

void Progress::update(std::size_t done) {
    const auto now = std::chrono::steady_clock::now();
    if (!visible_ || (Seconds(now - drawn_).count() < 0.1 && done < total_)) return;
    drawn_ = now;
    draw(done);
}

void Progress::draw(std::size_t done) {
    const double elapsed_s = Seconds(std::chrono::steady_clock::now() - start_).count();
    const double rate = elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0.0;
    const double percent =
        total_ > 0 ? 100.0 * static_cast<double>(done) / static_cast<double>(total_) : 0.0;
    std::fprintf(stderr, "\r\033[K%s %3.0f %%  %zu of %zu %s", title_.c_str(), percent, done,
                 total_, unit_.c_str());
    if (rate > 0 && done < total_)
        std::fprintf(stderr, "  %.3g %s/s, %.0f s left", rate, unit_.c_str(),
                     static_cast<double>(total_ - done) / rate);
    std::fflush(stderr);
}

}  // namespace stria

#pragma once
#include <chrono>
#include <string>

#include "host/cli/command.h"

namespace stria {

/// A line on stderr with share done, rate and time left, renewed at most ten times a second;
/// silent unless stderr is a terminal, and with --quiet.
class Progress {
  public:
    /// @param unit  what is counted: "frames", "views"
    Progress(const Context& context, std::string title, std::size_t total, std::string unit);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    void update(std::size_t done);

  private:
    void draw(std::size_t done);
    bool visible_ = false;
    std::string title_, unit_;
    std::size_t total_ = 0;
    std::chrono::steady_clock::time_point start_, drawn_;
};

}  // namespace stria

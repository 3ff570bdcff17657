#include <cstdio>
#include <filesystem>

#include "host/cli/command.h"
#include "host/core/errors.h"
#include "host/io/mesh_io.h"

namespace stria {

double Context::mm_per_unit() const { return unit.empty() ? 1.0 : stria::mm_per_unit(unit); }

void Context::say(const std::string& line) const {
    if (!quiet) std::fprintf(json ? stderr : stdout, "%s\n", line.c_str());
}

void Context::check_output(const std::string& path) const {
    if (!force && std::filesystem::exists(path))
        throw Error(path + " exists already; choose another name or add --force");
}

void Context::finish(const JsonResult& result) const {
    if (json) std::printf("%s\n", result.text().c_str());
    std::fflush(stdout);
}

}  // namespace stria

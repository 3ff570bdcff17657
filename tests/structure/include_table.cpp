#include "tests/structure/include_table.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace stria::structure {
namespace {

/// First prefix that a header's name begins with names its group.
constexpr std::array<std::pair<std::string_view, std::string_view>, 61> kGroups = {{
    {"Eigen/", "eigen"},       {"unsupported/Eigen/", "eigen"},
    {"ceres/", "ceres"},       {"glog/", "ceres"},
    {"opencv2/", "opencv"},    {"embree3/", "embree"},
    {"CLI/", "cli11"},         {"toml++/", "toml"},
    {"nlohmann/", "json"},     {"spdlog/", "spdlog"},
    {"fmt/", "spdlog"},        {"png.h", "png"},
    {"jpeglib.h", "jpeg"},     {"jerror.h", "jpeg"},
    {"tiff", "tiff"},          {"flatbuffers/", "flatbuffers"},
    {"zstd", "zstd"},          {"tbb/", "tbb"},
    {"oneapi/tbb", "tbb"},     {"hwy/", "simd"},
    {"nmmintrin.h", "simd"},   {"libusb-1.0/", "libusb"},
    {"libusb.h", "libusb"},    {"gpiod.h", "gpiod"},
    {"libaio.h", "aio"},       {"openssl/", "openssl"},
    {"pybind11/", "pybind11"}, {"gtest/", "gtest"},
    {"gmock/", "gtest"},       {"benchmark/", "benchmark"},
    {"sys/", "posix"},         {"linux/", "posix"},
    {"netinet/", "posix"},     {"arpa/", "posix"},
    {"net/", "posix"},         {"asm/", "posix"},
    {"unistd.h", "posix"},     {"fcntl.h", "posix"},
    {"poll.h", "posix"},       {"netdb.h", "posix"},
    {"signal.h", "posix"},     {"termios.h", "posix"},
    {"dirent.h", "posix"},     {"pthread.h", "posix"},
    {"sched.h", "posix"},      {"spawn.h", "posix"},
    {"dlfcn.h", "posix"},      {"strings.h", "posix"},
    {"endian.h", "posix"},     {"syslog.h", "posix"},
    {"ifaddrs.h", "posix"},    {"grp.h", "posix"},
    {"pwd.h", "posix"},        {"link.h", "posix"},
    {"malloc.h", "posix"},     {"errno.h", "posix"},
    {"time.h", "posix"},       {"stdlib.h", "posix"},
    {"stdio.h", "posix"},      {"string.h", "posix"},
    {"setjmp.h", "std"},
}};

std::vector<std::string> words(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> found;
    for (std::string word; in >> word;) found.push_back(word);
    return found;
}

bool matches(const std::string& pattern, const std::string& folder) {
    if (pattern == "*" || pattern == folder) return true;
    return pattern.ends_with("/*") && folder.starts_with(pattern.substr(0, pattern.size() - 1));
}

}  // namespace

IncludeTable read_include_table(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in) throw std::runtime_error("cannot read " + file.string());
    IncludeTable table;
    int number = 0;
    for (std::string line; std::getline(in, line);) {
        ++number;
        if (line.empty() || line.front() == '#') continue;
        const std::string place = file.string() + ":" + std::to_string(number);
        if (std::count(line.begin(), line.end(), ':') != 2) {
            throw std::runtime_error(place + ": expected FOLDER : folders : groups");
        }
        const std::size_t first = line.find(':');
        const std::size_t second = line.find(':', first + 1);
        const std::vector<std::string> folder = words(line.substr(0, first));
        if (folder.size() != 1) throw std::runtime_error(place + ": expected one folder");
        IncludeRow row = {.folders = words(line.substr(first + 1, second - first - 1)),
                          .groups = words(line.substr(second + 1))};
        if (!table.emplace(folder.front(), std::move(row)).second) {
            throw std::runtime_error(place + ": folder named twice: " + folder.front());
        }
    }
    return table;
}

std::string folder_of(const IncludeTable& table, const std::string& path) {
    std::string best;
    for (const auto& [folder, row] : table) {
        if ((path == folder || path.starts_with(folder + "/")) && folder.size() > best.size()) {
            best = folder;
        }
    }
    return best;
}

bool may_include(const IncludeTable& table, const std::string& from, const std::string& to) {
    if (from == to || to == "firmware/core") return true;
    const std::vector<std::string>& open = table.at(from).folders;
    return std::any_of(open.begin(), open.end(),
                       [&](const std::string& pattern) { return matches(pattern, to); });
}

std::string group_of(const std::string& header) {
    for (const auto& [prefix, group] : kGroups) {
        if (header.starts_with(prefix)) return std::string(group);
    }
    return header.find_first_of("/.") == std::string::npos ? "std" : "";
}

bool may_use(const IncludeRow& row, const std::string& group) {
    return group == "std" || std::any_of(row.groups.begin(), row.groups.end(),
                                         [&](const auto& g) { return g == "*" || g == group; });
}

}  // namespace stria::structure

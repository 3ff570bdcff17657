#include <algorithm>
#include <filesystem>

#include "host/core/errors.h"
#include "host/io/mesh_io.h"
#include "host/io/range_io.h"
#include "host/project/project.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

std::string ending_of(const std::string& path) {
    std::string ending = fs::path(path).extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return ending;
}

ScanSource scan_in(const ScanFolder& scan) {
    ScanSource source;
    source.name = scan.folder;
    if (fs::is_regular_file(scan.recording())) source.recording = scan.recording();
    if (fs::is_regular_file(scan.range())) source.range = scan.range();
    return source;
}

bool has_nothing(const ScanSource& source) {
    return source.recording.empty() && source.range.empty();
}

ScanSource scan_file(const std::string& path) {
    ScanSource source;
    source.name = path;
    const std::string ending = ending_of(path);
    if (ending == ".stria")
        source.recording = path;
    else if (ending == ".ply")
        (has_range_grid(path) ? source.range : source.points) = path;
    else if (is_points_only_path(path))
        source.points = path;
    else
        throw FileError(path, "",
                        "expected a scan (.stria, .ply, .pcd, .xyz, .csv, a scan folder or a "
                        "project), found " +
                            (ending.empty() ? "no ending" : ending));
    return source;
}

std::vector<ScanSource> scans_of_project(const std::string& folder) {
    std::vector<ScanSource> sources;
    for (const ScanFolder& scan : list_scans(open_project(folder))) {
        sources.push_back(scan_in(scan));
        if (has_nothing(sources.back()))
            throw FileError(scan.folder, "",
                            "expected recording.stria or range.ply in the scan's folder, found "
                            "neither");
    }
    if (sources.empty())
        throw FileError(folder, "",
                        "expected a project with scans, found none in its scans folder");
    return sources;
}

std::vector<ScanSource> resolve(std::string argument) {
    while (argument.size() > 1 && argument.back() == '/') argument.pop_back();
    std::error_code error;
    const fs::file_status status = fs::status(argument, error);
    if (!fs::exists(status)) throw FileError(argument, "", "no such file or folder");
    if (!fs::is_directory(status)) return {scan_file(argument)};
    if (is_project(argument)) return scans_of_project(argument);
    const ScanSource source = scan_in({argument, fs::path(argument).filename().string()});
    if (has_nothing(source))
        throw FileError(argument, "",
                        "expected a project (with project.toml) or a scan folder (with "
                        "recording.stria or range.ply), found neither");
    return {source};
}

}  // namespace

std::vector<ScanSource> resolve_scans(const std::vector<std::string>& arguments) {
    std::vector<ScanSource> sources;
    std::vector<std::string> seen;
    for (const std::string& argument : arguments)
        for (ScanSource& source : resolve(argument)) {
            const std::string place = fs::weakly_canonical(source.name).string();
            if (std::find(seen.begin(), seen.end(), place) != seen.end())
                throw FileError(source.name, "", "the scan is named twice");
            seen.push_back(place);
            sources.push_back(std::move(source));
        }
    return sources;
}

}  // namespace stria

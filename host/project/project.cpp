#include "host/project/project.h"

#include <algorithm>
#include <filesystem>

#include "host/core/errors.h"
#include "host/io/number_text.h"
#include "host/io/toml_file.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

std::string without_end_slash(std::string folder) {
    while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
    return folder;
}

void make_folder(const std::string& path) {
    std::error_code error;
    fs::create_directory(path, error);
    if (error) throw FileError(path, "", "cannot make the folder: " + error.message());
}

bool is_free(const std::string& folder) {
    std::error_code error;
    return !fs::exists(folder, error) || (fs::is_directory(folder, error) && fs::is_empty(folder));
}

/// The number of a scan folder's name; 0 if it is none.
std::int64_t scan_number(const std::string& name) {
    const auto number = parse_integer(name);
    return number && *number > 0 && name[0] != '+' ? *number : 0;
}

std::string scan_name(std::int64_t number) {
    const std::string digits = std::to_string(number);
    return std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits;
}

}  // namespace

bool is_project(const std::string& folder) {
    std::error_code error;
    return fs::is_regular_file(folder + "/project.toml", error);
}

Project create_project(const std::string& folder, const std::string& name) {
    Project project;
    project.folder = without_end_slash(folder);
    if (is_project(project.folder))
        throw FileError(folder, "", "expected a new project, found one that exists");
    if (!is_free(project.folder))
        throw FileError(folder, "", "expected an empty or new folder, found other content in it");
    project.name =
        name.empty() ? fs::absolute(project.folder).lexically_normal().filename().string() : name;
    project.stria_version = STRIA_VERSION;
    make_folder(project.folder);
    make_folder(project.scans());
    // Last, so that a folder with project.toml is a whole project.
    write_whole_file(project.file("project.toml"),
                     "[project]\nname = " + toml_text(project.name) +
                         "\nstria_version = " + toml_text(project.stria_version) + "\n");
    return project;
}

Project open_project(const std::string& folder) {
    Project project;
    project.folder = without_end_slash(folder);
    if (!is_project(project.folder))
        throw FileError(folder, "", "expected a project folder, found no project.toml in it");
    TomlTable top = read_toml(project.file("project.toml"));
    TomlTable table = top.table("project");
    project.name = table.text("name", "");
    project.stria_version = table.text("stria_version", "");
    top.finish();
    return project;
}

Project open_or_create_project(const std::string& folder) {
    return is_project(folder) ? open_project(folder) : create_project(folder);
}

std::vector<ScanFolder> list_scans(const Project& project) {
    std::vector<std::pair<std::int64_t, ScanFolder>> found;
    std::error_code error;
    fs::directory_iterator entries(project.scans(), error);
    if (error) return {};  // no scans/ yet
    for (const auto& entry : entries) {
        const std::string name = entry.path().filename().string();
        if (!entry.is_directory() || name[0] == '.') continue;
        const std::int64_t number = scan_number(name);
        if (number == 0)
            throw FileError(entry.path().string(), "",
                            "expected scan folders named by numbers (0001), found '" + name + "'");
        found.push_back({number, {project.scans() + "/" + name, name}});
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
        return std::tie(a.first, a.second.name) < std::tie(b.first, b.second.name);
    });
    std::vector<ScanFolder> scans;
    for (auto& [number, scan] : found) scans.push_back(std::move(scan));
    return scans;
}

ScanFolder make_next_scan(const Project& project) {
    const std::vector<ScanFolder> scans = list_scans(project);
    if (scans.empty() && !fs::exists(project.scans())) make_folder(project.scans());
    std::int64_t number = scans.empty() ? 1 : scan_number(scans.back().name) + 1;
    for (;; ++number) {
        const std::string name = scan_name(number);
        const std::string folder = project.scans() + "/" + name;
        std::error_code error;
        if (fs::create_directory(folder, error)) return {folder, name};  // false: it exists
        if (error) throw FileError(folder, "", "cannot make the folder: " + error.message());
    }
}

std::string relative_name(const std::string& file, const std::string& beside) {
    const fs::path folder = fs::absolute(beside).parent_path();
    return fs::absolute(file).lexically_normal().lexically_proximate(folder.lexically_normal());
}

}  // namespace stria

#include "tests/structure/source_tree.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <stdexcept>

namespace stria::structure {
namespace {

SourceFile read_source(const std::filesystem::path& root, const std::filesystem::path& path) {
    std::ifstream in(path);
    if (!in) throw std::runtime_error("cannot read " + path.string());
    SourceFile file = {.path = path.lexically_relative(root).generic_string(), .includes = {}};
    for (std::string line; std::getline(in, line);) {
        ++file.lines;
        std::size_t at = line.find_first_not_of(" \t");
        if (at == std::string::npos || line[at] != '#') continue;
        at = line.find_first_not_of(" \t", at + 1);
        if (at == std::string::npos || line.compare(at, 7, "include") != 0) continue;
        const std::size_t open = line.find_first_of("\"<", at);
        if (open == std::string::npos) continue;
        const std::size_t close = line.find(line[open] == '<' ? '>' : '"', open + 1);
        if (close == std::string::npos) continue;
        file.includes.push_back({.name = line.substr(open + 1, close - open - 1),
                                 .quoted = line[open] == '"',
                                 .line = file.lines});
    }
    return file;
}

}  // namespace

std::vector<SourceFile> read_source_tree(const std::filesystem::path& root) {
    std::vector<SourceFile> files;
    for (const char* top : {"firmware", "host", "calib", "sim", "tests"}) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(root / top)) {
            const std::string extension = entry.path().extension();
            if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
            files.push_back(read_source(root, entry.path()));
        }
    }
    std::sort(files.begin(), files.end(),
              [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
    return files;
}

std::vector<std::string> find_cycle(const Graph& graph) {
    std::set<std::string> done;
    std::vector<std::string> path;
    // Depth first; `path` holds the open nodes, so an arrow back into it closes a cycle.
    const std::function<bool(const std::string&)> visit = [&](const std::string& node) {
        const auto open = std::find(path.begin(), path.end(), node);
        if (open != path.end()) {
            path.erase(path.begin(), open);
            path.push_back(node);
            return true;
        }
        if (!done.insert(node).second) return false;
        path.push_back(node);
        if (const auto arrows = graph.find(node); arrows != graph.end()) {
            for (const std::string& next : arrows->second) {
                if (visit(next)) return true;
            }
        }
        path.pop_back();
        return false;
    };
    for (const auto& [node, arrows] : graph) {
        if (visit(node)) return path;
    }
    return {};
}

}  // namespace stria::structure

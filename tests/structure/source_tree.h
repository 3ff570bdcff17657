#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace stria::structure {

/// One #include line.
struct Include {
    std::string name;     ///< as written between the quotes or brackets
    bool quoted = false;  ///< "name", else <name>
    int line = 0;
};

/// One source or header; `path` is relative to the repository's root.
struct SourceFile {
    std::string path;
    std::vector<Include> includes;
    int lines = 0;

    bool is_header() const { return path.ends_with(".h"); }
};

/// Every .h and .cpp below firmware/, host/, calib/, sim/ and tests/, sorted by path.
std::vector<SourceFile> read_source_tree(const std::filesystem::path& root);

/// Arrows of a directed graph.
using Graph = std::map<std::string, std::set<std::string>>;

/// The nodes of one cycle, first and last the same; empty when there is none.
std::vector<std::string> find_cycle(const Graph& graph);

}  // namespace stria::structure

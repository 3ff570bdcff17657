#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/structure/include_table.h"
#include "tests/structure/source_tree.h"

namespace stria::structure {
namespace {

struct Library {
    std::string folder;
    std::vector<std::string> links;
};

/// The build's libraries by name, as write_targets.cmake wrote them while configuring.
std::map<std::string, Library> read_libraries() {
    std::ifstream in(STRIA_BINARY_DIR "/structure/targets.txt");
    std::map<std::string, Library> libraries;
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string name, colon;
        Library library;
        words >> name >> library.folder >> colon;
        for (std::string link; words >> link;) library.links.push_back(link);
        libraries[name] = library;
    }
    return libraries;
}

/// What `name` links, directly and through libraries of ours; also names from outside.
std::set<std::string> reach(const std::map<std::string, Library>& libraries,
                            const std::string& name) {
    std::set<std::string> reached;
    std::vector<std::string> open = {name};
    while (!open.empty()) {
        const std::string next = open.back();
        open.pop_back();
        if (!reached.insert(next).second) continue;
        if (const auto found = libraries.find(next); found != libraries.end()) {
            open.insert(open.end(), found->second.links.begin(), found->second.links.end());
        }
    }
    return reached;
}

bool is_heavy(const std::string& link) {
    return link.find("eres") != std::string::npos || link.find("opencv") != std::string::npos;
}

TEST(LinkTable, LibrariesLinkOnlyWhatTheirFolderMayInclude) {
    const IncludeTable table =
        read_include_table(std::string(STRIA_SOURCE_DIR) + "/tests/structure/include_table.txt");
    const auto libraries = read_libraries();
    ASSERT_FALSE(libraries.empty());
    for (const auto& [name, library] : libraries) {
        const std::string from = folder_of(table, library.folder);
        ASSERT_NE(from, "") << name << " in " << library.folder;
        for (const std::string& link : library.links) {
            const auto target = libraries.find(link);
            if (target == libraries.end()) continue;
            EXPECT_TRUE(may_include(table, from, folder_of(table, target->second.folder)))
                << name << " (" << from << ") may not link " << link;
        }
    }
}

TEST(LinkTable, LibrariesLinkEachOtherInNoCycle) {
    Graph graph;
    for (const auto& [name, library] : read_libraries()) {
        for (const std::string& link : library.links) graph[name].insert(link);
    }
    EXPECT_EQ(find_cycle(graph), std::vector<std::string>());
}

TEST(LinkTable, OnlyCalibReachesCeresAndOpenCv) {
    const auto libraries = read_libraries();
    for (const auto& [name, library] : libraries) {
        if (library.folder.starts_with("calib") || library.folder == "host/cli") continue;
        for (const std::string& link : reach(libraries, name)) {
            EXPECT_FALSE(is_heavy(link)) << name << " reaches " << link;
        }
    }
}

TEST(LinkTable, FirmwareReachesNothingOfTheHost) {
    const auto libraries = read_libraries();
    for (const auto& [name, library] : libraries) {
        if (!library.folder.starts_with("firmware/")) continue;
        for (const std::string& link : reach(libraries, name)) {
            const auto target = libraries.find(link);
            if (target == libraries.end()) continue;
            EXPECT_TRUE(target->second.folder.starts_with("firmware/")) << name << ": " << link;
        }
    }
}

}  // namespace
}  // namespace stria::structure

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/structure/include_table.h"
#include "tests/structure/source_tree.h"

namespace stria::structure {
namespace {

const std::filesystem::path kRoot = STRIA_SOURCE_DIR;
constexpr std::size_t kFewFiles = 3;  // CLI11, toml++, json and spdlog are slow to compile

const IncludeTable& table() {
    static const IncludeTable read =
        read_include_table(kRoot / "tests/structure/include_table.txt");
    return read;
}

const std::vector<SourceFile>& tree() {
    static const std::vector<SourceFile> read = read_source_tree(kRoot);
    return read;
}

/// Written by flatc.
bool is_generated(const std::string& name) { return name.ends_with("_generated.h"); }

std::string place(const SourceFile& file, const Include& include) {
    return file.path + ":" + std::to_string(include.line) + ": " + include.name;
}

TEST(IncludeTable, KnowsTheFolderOfEverySource) {
    for (const SourceFile& file : tree()) EXPECT_NE(folder_of(table(), file.path), "") << file.path;
}

TEST(IncludeTable, EveryQuotedPathStartsAtTheRoot) {
    for (const SourceFile& file : tree()) {
        for (const Include& include : file.includes) {
            if (!include.quoted || is_generated(include.name)) continue;
            if (std::filesystem::exists(kRoot / (include.name + ".in"))) continue;
            EXPECT_TRUE(std::filesystem::is_regular_file(kRoot / include.name))
                << place(file, include) << ": write the path from the repository's root";
        }
    }
}

TEST(IncludeTable, FoldersIncludeOnlyWhatTheirRowAllows) {
    for (const SourceFile& file : tree()) {
        const std::string from = folder_of(table(), file.path);
        for (const Include& include : file.includes) {
            if (!include.quoted) continue;
            const std::string to = folder_of(table(), include.name);
            if (to.empty()) continue;  // a generated header named without its folder
            EXPECT_TRUE(may_include(table(), from, to))
                << place(file, include) << ": " << from << " may not include " << to;
        }
    }
}

TEST(IncludeTable, ThirdPartyHeadersStayInTheirHomes) {
    for (const SourceFile& file : tree()) {
        const std::string folder = folder_of(table(), file.path);
        for (const Include& include : file.includes) {
            if (include.quoted) continue;
            const std::string group = group_of(include.name);
            EXPECT_NE(group, "") << place(file, include)
                                 << ": unknown header, add it to include_table.cpp";
            EXPECT_TRUE(may_use(table().at(folder), group))
                << place(file, include) << ": " << folder << " may not use " << group;
        }
    }
}

/// Headers that show a third-party type other than Eigen's, directly or through another of them.
std::set<std::string> private_headers() {
    std::set<std::string> found;
    std::size_t before = 0;
    do {
        before = found.size();
        for (const SourceFile& file : tree()) {
            if (!file.is_header() || file.path.starts_with("tests/")) continue;
            for (const Include& include : file.includes) {
                const std::string group = include.quoted ? "std" : group_of(include.name);
                if ((group != "std" && group != "eigen") || is_generated(include.name) ||
                    found.count(include.name) > 0) {
                    found.insert(file.path);
                }
            }
        }
    } while (found.size() != before);
    return found;
}

TEST(IncludeTable, HeadersWithThirdPartyTypesStayInTheirFolder) {
    const std::set<std::string> hidden = private_headers();
    for (const SourceFile& file : tree()) {
        for (const Include& include : file.includes) {
            if (hidden.count(include.name) == 0 || file.path.starts_with("tests/")) continue;
            EXPECT_EQ(folder_of(table(), file.path), folder_of(table(), include.name))
                << place(file, include) << ": it shows a third-party type";
        }
    }
}

TEST(IncludeTable, SlowHeadersStandInFewFiles) {
    std::map<std::string, std::set<std::string>> users;
    for (const SourceFile& file : tree()) {
        if (file.path.starts_with("tests/")) continue;
        for (const Include& include : file.includes) {
            if (!include.quoted) users[group_of(include.name)].insert(file.path);
        }
    }
    for (const char* group : {"cli11", "toml", "json", "spdlog"}) {
        EXPECT_LE(users[group].size(), kFewFiles)
            << group << " in " << testing::PrintToString(users[group]);
    }
}

TEST(IncludeTable, FilesIncludeEachOtherInNoCycle) {
    Graph graph;
    for (const SourceFile& file : tree()) {
        for (const Include& include : file.includes) {
            if (include.quoted) graph[file.path].insert(include.name);
        }
    }
    EXPECT_EQ(find_cycle(graph), std::vector<std::string>());
}

TEST(IncludeTable, FoldersIncludeEachOtherInNoCycle) {
    Graph graph;
    for (const SourceFile& file : tree()) {
        if (file.path.starts_with("tests/")) continue;
        const std::string from = folder_of(table(), file.path);
        for (const Include& include : file.includes) {
            const std::string to = include.quoted ? folder_of(table(), include.name) : "";
            if (!to.empty() && to != from) graph[from].insert(to);
        }
    }
    EXPECT_EQ(find_cycle(graph), std::vector<std::string>());
}

TEST(IncludeTable, SourcesStayBelowFiveHundredLines) {
    for (const SourceFile& file : tree()) {
        EXPECT_LE(file.lines, 500) << file.path << ": cut it where its subjects part";
    }
}

// The checks above are only worth something if they can fail.
TEST(IncludeTable, RowsForbidWhatTheyDoNotName) {
    EXPECT_TRUE(may_include(table(), "host/fusion", "host/geometry"));
    EXPECT_TRUE(may_include(table(), "host/fusion", "firmware/core"));
    EXPECT_FALSE(may_include(table(), "host/fusion", "host/registration"));
    EXPECT_FALSE(may_include(table(), "firmware/session", "host/core"));
    EXPECT_FALSE(may_include(table(), "calib", "sim"));
    EXPECT_FALSE(may_include(table(), "sim", "calib"));
    EXPECT_FALSE(may_include(table(), "tests/firmware", "host/core"));
    EXPECT_EQ(folder_of(table(), "sim/striad_sim/main.cpp"), "sim/striad_sim");
    EXPECT_EQ(folder_of(table(), "hostess/main.cpp"), "");
    EXPECT_FALSE(may_use(table().at("host/scan"), group_of("opencv2/core.hpp")));
    EXPECT_TRUE(may_use(table().at("calib"), group_of("opencv2/core.hpp")));
    EXPECT_EQ(group_of("vector"), "std");
    EXPECT_EQ(group_of("boost/any.hpp"), "");
}

TEST(IncludeTable, FindCycleNamesTheCycle) {
    EXPECT_TRUE(find_cycle({{"a", {"b", "c"}}, {"b", {"c"}}}).empty());
    const std::vector<std::string> cycle = {"b", "c", "b"};
    EXPECT_EQ(find_cycle({{"a", {"b"}}, {"b", {"c"}}, {"c", {"b"}}}), cycle);
}

}  // namespace
}  // namespace stria::structure

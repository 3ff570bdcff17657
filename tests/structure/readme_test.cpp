#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace stria::structure {
namespace {

const std::filesystem::path kRoot = STRIA_SOURCE_DIR;
constexpr std::array kTopFolders = {"firmware", "host", "calib", "sim", "tests", "tools"};

std::string read_text(const std::filesystem::path& file) {
    std::ifstream in(file);
    EXPECT_TRUE(in) << file;
    return {std::istreambuf_iterator<char>(in), {}};
}

/// The texts between backticks, in order.
std::vector<std::string> quoted_words(const std::string& text) {
    static const std::regex kQuoted("`([^`]+)`");
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), kQuoted), end; it != end; ++it) {
        found.push_back((*it)[1]);
    }
    return found;
}

TEST(Readme, TheWayOfAFrameNamesRealFilesAndFunctions) {
    std::istringstream lines(read_text(kRoot / "README.md"));
    int steps = 0;
    for (std::string line; std::getline(lines, line);) {
        static const std::regex kRow(R"(\| ([^|]+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \|)");
        std::smatch row;
        if (!std::regex_match(line, row, kRow)) continue;
        std::string code;
        for (const std::string& file : quoted_words(row[2])) {
            if (file.ends_with(".h")) code += read_text(kRoot / file);
        }
        if (code.empty()) continue;
        ++steps;
        for (const std::string& function : quoted_words(row[3])) {
            EXPECT_TRUE(std::regex_search(code, std::regex("\\b" + function + "\\(")))
                << row[2] << " declares no " << function;
        }
    }
    EXPECT_GE(steps, 15);
}

/// Our pages: the first one and those below the top folders.
std::vector<std::filesystem::path> pages() {
    std::vector<std::filesystem::path> found = {kRoot / "README.md"};
    for (const char* top : kTopFolders) {
        for (const auto& entry : std::filesystem::recursive_directory_iterator(kRoot / top)) {
            if (entry.path().filename() == "README.md") found.push_back(entry.path());
        }
    }
    return found;
}

TEST(Readme, LinksLeadSomewhere) {
    static const std::regex kLink(R"(\]\(([^):#]+)\))");
    for (const std::filesystem::path& page : pages()) {
        const std::string text = read_text(page);
        for (std::sregex_iterator it(text.begin(), text.end(), kLink), end; it != end; ++it) {
            EXPECT_TRUE(std::filesystem::exists(page.parent_path() / (*it)[1].str()))
                << page << " links " << (*it)[1];
        }
    }
}

TEST(Readme, EveryTopFolderHasOne) {
    for (const char* top : kTopFolders) {
        EXPECT_TRUE(std::filesystem::is_regular_file(kRoot / top / "README.md")) << top;
    }
}

}  // namespace
}  // namespace stria::structure

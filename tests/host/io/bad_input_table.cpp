// Prints "file, message, time, peak memory" for every file given, or in the folders given.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "tests/host/io/guarded_run.h"

namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_of(int argc, char** argv) {
    std::vector<std::string> files;
    for (int i = 1; i < argc; ++i) {
        if (!fs::is_directory(argv[i])) {
            files.emplace_back(argv[i]);
            continue;
        }
        for (const auto& entry : fs::directory_iterator(argv[i]))
            if (entry.path().extension() != ".md") files.push_back(entry.path().string());
    }
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bad_input_table FILE_OR_FOLDER...\n");
        return 2;
    }
    bool good = true;
    std::printf("%-62s %8s %8s  %s\n", "file", "ms", "MB", "message");
    for (const std::string& file : files_of(argc, argv)) {
        const auto result = stria::run_guarded([&] { return stria::describe_file(file); });
        std::string message = result.message;  // the file's name stands in the first column
        if (message.starts_with(file + ": ")) message.erase(0, file.size() + 2);
        std::printf("%-62s %8.1f %8.1f  %s%s\n", fs::path(file).filename().c_str(),
                    1e3 * result.seconds, result.peak_mb, result.refused ? "refused: " : "",
                    message.c_str());
        good = good && !result.crashed && result.seconds <= 2.0 && result.peak_mb <= 200.0;
    }
    return good ? 0 : 1;
}

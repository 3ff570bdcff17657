#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "host/cli/run.h"

namespace stria::test_support {

/// Exit code and what was printed.
struct Ended {
    int code;
    std::string out, err;
};

/// The program with these arguments, in this process.
inline Ended run_stria(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int code = run_program(static_cast<int>(argv.size()), argv.data());
    return {code, testing::internal::GetCapturedStdout(), testing::internal::GetCapturedStderr()};
}

inline bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

/// The number after "key": at its first place in a JSON text; NaN if it is not there.
inline double number_of(const std::string& json, const std::string& key) {
    const std::size_t at = json.find("\"" + key + "\":");
    return at == std::string::npos ? NAN : std::stod(json.substr(at + key.size() + 3));
}

}  // namespace stria::test_support

#pragma once
#include <cstdio>
#include <string>

namespace stria {

/// `value` in at most `digits` significant digits, for messages.
inline std::string short_number(double value, int digits = 4) {
    char text[40];
    std::snprintf(text, sizeof text, "%.*g", digits, value);
    return text;
}

}  // namespace stria

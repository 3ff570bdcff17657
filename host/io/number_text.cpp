#include "host/io/number_text.h"

#include <charconv>
#include <cmath>
#include <cstdio>

#include "host/core/errors.h"

namespace stria {
namespace {

template <typename T>
void append(std::string& text, T value) {
    char buffer[40];
    const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
    text.append(buffer, result.ptr);
}

std::string_view without_plus(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    return word;
}

}  // namespace

void append_number(std::string& text, double value) { append(text, value); }
void append_number(std::string& text, float value) { append(text, value); }
void append_number(std::string& text, std::int64_t value) { append(text, value); }

std::string toml_number(double value) {
    if (!std::isfinite(value))
        throw Error("cannot write a number that is not finite to a TOML file");
    std::string text;
    append(text, value);
    if (text.find_first_of(".e") == std::string::npos) text += ".0";
    return text;
}

std::string toml_text(std::string_view value) {
    std::string text = "\"";
    for (const char c : value) {
        if (c == '"' || c == '\\') {
            text += '\\';
            text += c;
        } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) {
            char escape[8];
            std::snprintf(escape, sizeof escape, "\\u%04X", static_cast<unsigned>(c));
            text += escape;
        } else {
            text += c;
        }
    }
    return text + "\"";
}

std::optional<double> parse_number(std::string_view word) {
    word = without_plus(word);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || word.empty()) return std::nullopt;
    if (error == std::errc{}) return value;
    // Out of range: below the smallest double is 0, above the greatest is an error.
    const std::size_t exponent = word.find_first_of("eE");
    const bool tiny = exponent == std::string_view::npos
                          ? word.find_first_of('.') <= 1 + (word[0] == '-' ? 1U : 0U)
                          : word.substr(exponent + 1, 1) == "-";
    if (error == std::errc::result_out_of_range && tiny) return word[0] == '-' ? -0.0 : 0.0;
    return std::nullopt;
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
    word = without_plus(word);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
    return value;
}

}  // namespace stria

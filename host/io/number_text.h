#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

/// Numbers as text, independent of the locale.
namespace stria {

/// Appends the shortest text that reads back as the same value.
void append_number(std::string& text, double value);
void append_number(std::string& text, float value);
void append_number(std::string& text, std::int64_t value);

/// The same as TOML takes it: a float keeps a point or an exponent ("1.0"). Throws stria::Error on
/// numbers that are not finite: no file of ours can hold them.
std::string toml_number(double value);
/// A text in double quotes with everything escaped that TOML asks for.
std::string toml_text(std::string_view value);

/// The whole word as a number; a leading '+' is allowed, "nan" and "inf" are numbers, too small
/// ones become 0. Empty if it is none or too large.
std::optional<double> parse_number(std::string_view word);
std::optional<std::int64_t> parse_integer(std::string_view word);

}  // namespace stria

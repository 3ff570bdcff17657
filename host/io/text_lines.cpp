#include "host/io/text_lines.h"

#include <cmath>

#include "host/io/number_text.h"

namespace stria {

std::string shown(std::string_view text) {
    std::string result;
    for (const char c : text.substr(0, 40)) result += c >= 0x20 && c < 0x7F ? c : '?';
    if (text.size() > 40) result += "...";
    return result;
}

TextLines::TextLines(std::string_view text, std::string name, std::string_view separators)
    : text_(text), name_(std::move(name)) {
    for (const char c : separators) separates_[static_cast<unsigned char>(c)] = true;
}

bool TextLines::next() {
    if (at_ >= text_.size()) return false;
    std::size_t end = at_;
    while (end < text_.size() && text_[end] != '\n' && text_[end] != '\r') ++end;
    line_ = text_.substr(at_, end - at_);
    if (end + 1 < text_.size() && text_[end] == '\r' && text_[end + 1] == '\n') ++end;
    at_ = std::min(end + 1, text_.size());
    column_ = 0;
    ++number_;
    return true;
}

std::string_view TextLines::rest() {
    while (column_ < line_.size() && separates_[static_cast<unsigned char>(line_[column_])])
        ++column_;
    return line_.substr(column_);
}

std::string_view TextLines::word() {
    const std::string_view from = rest();
    std::size_t length = 0;
    while (length < from.size() && !separates_[static_cast<unsigned char>(from[length])]) ++length;
    column_ += length;
    return from.substr(0, length);
}

double TextLines::number(const char* what) {
    const std::string_view found = word();
    const auto value = parse_number(found);
    if (!value)
        fail(std::string("expected ") + what +
             (found.empty() ? ", found the end of the line" : ", found '" + shown(found) + "'"));
    return *value;
}

double TextLines::finite_number(const char* what) {
    const double value = number(what);
    if (!std::isfinite(value))
        fail(std::string("expected ") + what + ", found a number that is not finite");
    return value;
}

std::int64_t TextLines::integer(const char* what) {
    const std::string_view found = word();
    const auto value = parse_integer(found);
    if (!value)
        fail(std::string("expected ") + what +
             (found.empty() ? ", found the end of the line" : ", found '" + shown(found) + "'"));
    return *value;
}

void TextLines::fail(const std::string& what) const {
    throw FileError(name_, "line " + std::to_string(number_), what);
}

}  // namespace stria

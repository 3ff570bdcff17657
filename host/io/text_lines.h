#pragma once
#include <cstddef>
#include <string>
#include <string_view>

#include "host/core/errors.h"

namespace stria {

/// A piece of a file as an error message shows it: at most 40 bytes, the unprintable as '?'.
std::string shown(std::string_view text);

/// Walks a text line by line (ended by LF, CR LF or CR) and word by word, knowing where it is.
/// Borrows the text.
class TextLines {
  public:
    /// @param name       the path in errors
    /// @param separators between words
    TextLines(std::string_view text, std::string name, std::string_view separators = " \t\v\f");

    /// Goes to the next line; false at the end.
    bool next();
    /// The line, whole.
    std::string_view line() const { return line_; }
    std::size_t line_number() const { return number_; }
    /// Bytes from the start of the text to the line after this one.
    std::size_t offset() const { return at_; }
    /// Bytes not yet walked, this line left out.
    std::size_t left() const { return text_.size() - at_; }
    /// The rest of the line, separators at its start left out.
    std::string_view rest();

    /// Goes on after the first `bytes` of rest().
    void skip(std::size_t bytes) { column_ += rest().substr(0, bytes).size(); }
    /// Next word of this line; empty at its end.
    std::string_view word();
    /// Next word as a number. Throws FileError that says that `what` was expected.
    double number(const char* what);
    double finite_number(const char* what);
    std::int64_t integer(const char* what);

    [[noreturn]] void fail(const std::string& what) const;

  private:
    std::string_view text_;
    std::string name_;
    bool separates_[256] = {};
    std::string_view line_;
    std::size_t at_ = 0;      ///< of the next line
    std::size_t column_ = 0;  ///< of the next word
    std::size_t number_ = 0;
};

}  // namespace stria

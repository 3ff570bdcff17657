#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace stria {

/// Levenshtein distance: fewest insertions, deletions and replacements of one byte that turn a into
/// b. Words longer than 256 bytes are cut there.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The candidate with the least edit distance to `word`, the first of equals; empty if there are
/// none.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace stria

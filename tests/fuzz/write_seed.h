#pragma once
#include <filesystem>
#include <string_view>

namespace stria {

/// Writes one file of a corpus, and its folder if need be.
void write_seed(const std::filesystem::path& file, std::string_view bytes);

/// The seeds of fuzz_message and fuzz_framing, below the folder of all corpora. Apart from the
/// other writers because protocol and scanner model each have a Channel.
void write_wire_seeds(const std::filesystem::path& corpus);

/// Those of fuzz_fast_spacetime.
void write_sweep_seeds(const std::filesystem::path& corpus);

}  // namespace stria

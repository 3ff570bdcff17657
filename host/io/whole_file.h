#pragma once
#include <string>
#include <string_view>

namespace stria {

/// The file's bytes. Throws FileError if it cannot be read or exceeds max_bytes.
std::string read_whole_file(const std::string& path, std::size_t max_bytes = std::size_t{1} << 32);

/// The first `bytes` of the file, or all of it if it is shorter. Throws FileError.
std::string read_file_start(const std::string& path, std::size_t bytes);

/// Writes bytes under a temporary name, fsyncs and renames, so that a killed command leaves the old
/// file or the new one. Throws FileError.
void write_whole_file(const std::string& path, std::string_view bytes);

}  // namespace stria

#pragma once
#include <string>
#include <string_view>

#include "host/io/image_io.h"

/// The formats behind image_io.h, one file each. `name` stands for the path in errors.
namespace stria {

LoadedImage decode_png(std::string_view bytes, const std::string& name);
LoadedImage decode_jpeg(std::string_view bytes, const std::string& name);
LoadedImage decode_tiff(std::string_view bytes, const std::string& name);

/// Throws FileError unless an image of that size can be meant by a file of so many bytes: sides of
/// 1 to 32768 px, at most 2^28 samples, and no more than 4096 samples a byte plus 2^22 (no format
/// here packs real images tighter). Called before memory is taken.
void check_image_size(const std::string& name, std::size_t file_bytes, std::uint64_t width,
                      std::uint64_t height, std::uint64_t channels);

}  // namespace stria

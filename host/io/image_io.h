#pragma once
#include <string>
#include <string_view>

#include "host/core/image.h"

namespace stria {

/// Any image file as 8-bit interleaved channels (1 or 3; alpha dropped, palettes expanded), or as
/// 16-bit where the file has more than 8 bits. PNG, JPEG, TIFF, recognised by their content.
struct LoadedImage {
    Image<std::uint16_t> pixels;  ///< 1 or 3 channels
    int bits = 8;                 ///< 8 or 16
};
/// Throws FileError, also for a file that ends too early or claims a size its bytes cannot hold.
/// Values stay as stored: no gamma, no colour profile, no Exif rotation.
LoadedImage read_image(const std::string& path);
/// The same from memory; `name` stands for the path in errors.
LoadedImage parse_image(std::string_view bytes, const std::string& name);

enum class ColourChannel { automatic, red, green, blue, grey };
/// One channel of an image; automatic: the one with the greatest 99.9th percentile above its median
/// (the stripe's colour) for colour images. Grey is the Rec. 601 luma.
Grey16Image select_channel(const LoadedImage& image, ColourChannel channel);
/// The channel `automatic` stands for in this image.
ColourChannel strongest_channel(const LoadedImage& image);
ColourChannel colour_channel_from(const std::string& name);  ///< throws stria::Error on others

/// Grey as 8 bits (16-bit images scaled down), for target detection and textures.
GreyImage read_grey_image(const std::string& path);

/// Written whole or not at all. 1 or 3 channels.
void write_png(const std::string& path, const Image<std::uint8_t>& image);
void write_png(const std::string& path, const Grey16Image& image);
/// A PNG in memory, for pages.
std::string encode_png(const Image<std::uint8_t>& image);
std::string encode_png(const Grey16Image& image);

}  // namespace stria

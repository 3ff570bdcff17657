#pragma once
#include <string>

#include "host/core/image.h"

namespace stria {

/// Files in memory, written by libjpeg and libtiff themselves.
std::string encode_jpeg(const Image<std::uint8_t>& image, int quality);
std::string encode_tiff(const Image<std::uint8_t>& image, int compression);
std::string encode_tiff(const Image<std::uint16_t>& image, int compression);

}  // namespace stria

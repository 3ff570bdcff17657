#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace stria {

/// A PNG put together byte by byte from its specification, without libpng or zlib: stored deflate
/// blocks, filter 0. For kinds of PNG that our own writer does not make.
struct HandmadePng {
    unsigned width = 0, height = 0;
    unsigned bits = 8;         ///< a sample
    unsigned colour_type = 0;  ///< 0 grey, 2 RGB, 3 palette, 4 grey + alpha, 6 RGBA
    bool interlaced = false;   ///< Adam7
    std::string palette;       ///< PLTE: R G B bytes
    std::string transparency;  ///< tRNS
    /// Sample c of pixel (x, y).
    std::function<unsigned(unsigned x, unsigned y, unsigned c)> sample;
};

std::string encode(const HandmadePng& png);

}  // namespace stria

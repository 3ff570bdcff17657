#pragma once
#include <cstdint>
#include <span>

#include "firmware/core/result.h"
#include "firmware/protocol/framing.h"

namespace stria {

enum class Compression : std::uint8_t { none = 0, zstd = 1 };

struct Packed {
    Compression compression = Compression::none;
    Bytes bytes;
};

/// zstd at its fast level 1, kept only where it saves an eighth or more.
Packed pack(std::span<const std::uint8_t> bytes);

/// The `expected` bytes back. The size that the packed bytes claim is compared with `expected`
/// before any memory is taken.
Result<Bytes> unpack(std::uint8_t compression, std::span<const std::uint8_t> packed,
                     std::size_t expected);

}  // namespace stria

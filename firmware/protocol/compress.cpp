#include "firmware/protocol/compress.h"

#include <zstd.h>

#include <string>

namespace stria {
namespace {

Failure wrong_size(unsigned long long found, std::size_t expected) {
    return {"packed bytes: expected to hold " + std::to_string(expected) + " bytes, found " +
            std::to_string(found)};
}

}  // namespace

Packed pack(std::span<const std::uint8_t> bytes) {
    Packed packed;
    packed.bytes.resize(ZSTD_compressBound(bytes.size()));
    const std::size_t size =
        ZSTD_compress(packed.bytes.data(), packed.bytes.size(), bytes.data(), bytes.size(), 1);
    if (ZSTD_isError(size) == 0 && size + size / 7 < bytes.size()) {
        packed.bytes.resize(size);
        packed.compression = Compression::zstd;
        return packed;
    }
    packed.bytes.assign(bytes.begin(), bytes.end());
    return packed;
}

Result<Bytes> unpack(std::uint8_t compression, std::span<const std::uint8_t> packed,
                     std::size_t expected) {
    if (compression == static_cast<std::uint8_t>(Compression::none)) {
        if (packed.size() != expected) return wrong_size(packed.size(), expected);
        return Bytes(packed.begin(), packed.end());
    }
    if (compression != static_cast<std::uint8_t>(Compression::zstd))
        return Failure{"packed bytes: unknown compression " + std::to_string(compression)};
    const unsigned long long claimed = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (claimed == ZSTD_CONTENTSIZE_ERROR || claimed == ZSTD_CONTENTSIZE_UNKNOWN)
        return Failure{"packed bytes: not a zstd frame that states its size"};
    if (claimed != expected) return wrong_size(claimed, expected);
    Bytes bytes(expected);
    const std::size_t size =
        ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
    if (ZSTD_isError(size) != 0)
        return Failure{std::string("packed bytes: zstd: ") + ZSTD_getErrorName(size)};
    if (size != expected) return wrong_size(size, expected);
    return bytes;
}

}  // namespace stria

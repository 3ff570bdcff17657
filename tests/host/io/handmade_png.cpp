#include "tests/host/io/handmade_png.h"

namespace stria {
namespace {

std::string big_endian(std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
    return bytes;
}

/// PNG specification, annex D: CRC-32, bit by bit.
std::uint32_t crc32(const std::string& bytes) {
    std::uint32_t crc = 0xFFFFFFFF;
    for (const char c : bytes) {
        crc ^= static_cast<std::uint8_t>(c);
        for (int k = 0; k < 8; ++k) crc = crc & 1 ? 0xEDB88320 ^ crc >> 1 : crc >> 1;
    }
    return ~crc;
}

std::string chunk(const std::string& type, const std::string& data) {
    return big_endian(static_cast<std::uint32_t>(data.size())) + type + data +
           big_endian(crc32(type + data));
}

/// RFC 1950 around one stored block of RFC 1951.
std::string zlib_stored(const std::string& data) {
    const auto size = static_cast<std::uint32_t>(data.size());
    std::string bytes = "\x78\x01\x01";
    for (const std::uint32_t n : {size, ~size}) {
        bytes += static_cast<char>(n & 255);
        bytes += static_cast<char>(n >> 8 & 255);
    }
    std::uint32_t a = 1, b = 0;
    for (const char c : data) {
        a = (a + static_cast<std::uint8_t>(c)) % 65521;
        b = (b + a) % 65521;
    }
    return bytes + data + big_endian(b << 16 | a);
}

unsigned channels_of(unsigned colour_type) {
    switch (colour_type) {
        case 2:
            return 3;
        case 4:
            return 2;
        case 6:
            return 4;
        default:
            return 1;
    }
}

/// Rows of the pixels x0 + i dx, y0 + j dy, each after its filter byte.
std::string pass(const HandmadePng& png, unsigned x0, unsigned y0, unsigned dx, unsigned dy) {
    std::string data;
    for (unsigned y = y0; y < png.height && x0 < png.width; y += dy) {
        data += '\0';
        unsigned used = 0, byte = 0;
        for (unsigned x = x0; x < png.width; x += dx)
            for (unsigned c = 0; c < channels_of(png.colour_type); ++c) {
                const unsigned value = png.sample(x, y, c);
                for (int bit = static_cast<int>(png.bits) - 1; bit >= 0; --bit) {
                    byte = byte << 1 | (value >> bit & 1);
                    if (++used % 8 == 0) data += static_cast<char>(byte & 255);
                }
            }
        if (used % 8 != 0) data += static_cast<char>(byte << (8 - used % 8) & 255);
    }
    return data;
}

}  // namespace

std::string encode(const HandmadePng& png) {
    std::string header = big_endian(png.width) + big_endian(png.height);
    header += static_cast<char>(png.bits);
    header += static_cast<char>(png.colour_type);
    header += std::string(2, '\0') + static_cast<char>(png.interlaced);
    std::string data;
    if (!png.interlaced) {
        data = pass(png, 0, 0, 1, 1);
    } else {
        constexpr unsigned kPasses[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                            {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
        for (const auto& p : kPasses) data += pass(png, p[0], p[1], p[2], p[3]);
    }
    std::string bytes = "\x89PNG\r\n\x1A\n" + chunk("IHDR", header);
    if (!png.palette.empty()) bytes += chunk("PLTE", png.palette);
    if (!png.transparency.empty()) bytes += chunk("tRNS", png.transparency);
    return bytes + chunk("IDAT", zlib_stored(data)) + chunk("IEND", "");
}

}  // namespace stria

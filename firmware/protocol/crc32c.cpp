#include "firmware/protocol/crc32c.h"

#include <array>
#include <bit>
#include <cstring>
#if defined(__x86_64__)
#include <nmmintrin.h>
#endif

namespace stria {
namespace {

static_assert(std::endian::native == std::endian::little, "the tables are read little endian");

using Tables = std::array<std::array<std::uint32_t, 256>, 8>;

constexpr Tables make_tables() {
    Tables tables{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t crc = i;
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) ? 0x82F63B78U : 0U);
        tables[0][i] = crc;
    }
    for (std::size_t k = 1; k < 8; ++k)
        for (std::size_t i = 0; i < 256; ++i)
            tables[k][i] = (tables[k - 1][i] >> 8) ^ tables[0][tables[k - 1][i] & 0xFFU];
    return tables;
}

constexpr Tables kTables = make_tables();

std::uint64_t load64(const std::uint8_t* bytes) {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

#if defined(__x86_64__)
__attribute__((target("sse4.2"))) std::uint32_t crc32c_sse42(std::span<const std::uint8_t> bytes,
                                                             std::uint32_t crc) {
    std::uint64_t state = ~crc;
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) state = _mm_crc32_u64(state, load64(&bytes[i]));
    auto low = static_cast<std::uint32_t>(state);
    for (; i < bytes.size(); ++i) low = _mm_crc32_u8(low, bytes[i]);
    return ~low;
}
#endif

}  // namespace

std::uint32_t crc32c_by_tables(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
    std::uint32_t state = ~crc;
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) {
        const std::uint64_t word = load64(&bytes[i]) ^ state;
        state = 0;
        for (std::size_t k = 0; k < 8; ++k) state ^= kTables[7 - k][(word >> (8 * k)) & 0xFFU];
    }
    for (; i < bytes.size(); ++i) state = (state >> 8) ^ kTables[0][(state ^ bytes[i]) & 0xFFU];
    return ~state;
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
#if defined(__x86_64__)
    static const bool has_sse42 = __builtin_cpu_supports("sse4.2") != 0;
    if (has_sse42) return crc32c_sse42(bytes, crc);
#endif
    return crc32c_by_tables(bytes, crc);
}

}  // namespace stria

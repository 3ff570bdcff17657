#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace stria {

/// CRC-32C (Castagnoli, reflected 0x82F63B78, start and final xor all ones) of the bytes; `crc` is
/// the result for what came before them. Test vectors: RFC 3720, B.4. SSE4.2 where the processor
/// has it, else eight tables (slice by 8).
std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

/// The same by tables alone, on any processor.
std::uint32_t crc32c_by_tables(std::span<const std::uint8_t> bytes, std::uint32_t crc = 0);

}  // namespace stria

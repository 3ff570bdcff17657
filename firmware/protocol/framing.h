#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/result.h"

/// The one framing of sockets, USB bulk and files: a header of 32 bytes, little endian, then a
/// payload.  0 magic "STRI", 4 version u16, 6 channel u8, 7 zero, 8 type u16, 10 zero u16,
/// 12 length u32, 16 session u32, 20 sequence u32, 24 payload CRC-32C, 28 CRC-32C of bytes 0-27.
namespace stria {

/// Storage of a payload: std::vector's allocator aligns it to 16 bytes, as FlatBuffers wants it.
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kHeaderBytes = 32;
constexpr std::uint32_t kMaxPayloadBytes = 64U << 20;
constexpr std::uint16_t kProtocolVersion = 1;

enum class WireChannel : std::uint8_t { control = 0, data = 1, health = 2 };

enum class MessageType : std::uint16_t {
    snapshot = 1,
    frame = 2,
    axis_log = 3,
    pulse_band = 4,
    path_table = 5,
    health = 6,
    end = 7,
    request = 16,
    response = 17,
};

struct MessageHeader {
    WireChannel channel = WireChannel::data;
    MessageType type = MessageType::end;
    std::uint32_t length = 0;       ///< bytes of payload
    std::uint32_t session = 0;      ///< one number a run
    std::uint32_t sequence = 0;     ///< counts the messages of a session's channel from 0
    std::uint32_t payload_crc = 0;  ///< CRC-32C

    bool operator==(const MessageHeader&) const = default;
};

/// A framed message whose payload has not been looked at yet.
struct RawMessage {
    MessageHeader header;
    Bytes payload;
};

std::array<std::uint8_t, kHeaderBytes> encode_header(const MessageHeader& header);

/// Checks magic, header CRC, version, zeros, channel, type and length, in this order.
Result<MessageHeader> decode_header(std::span<const std::uint8_t, kHeaderBytes> bytes);

/// Fails unless length and CRC are the header's.
Status check_payload(const MessageHeader& header, std::span<const std::uint8_t> payload);

/// A message of that payload with length and CRC filled in. Precondition: payload within
/// kMaxPayloadBytes.
RawMessage make_raw(WireChannel channel, MessageType type, Bytes payload, std::uint32_t session,
                    std::uint32_t sequence);

}  // namespace stria

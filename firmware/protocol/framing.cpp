#include "firmware/protocol/framing.h"

#include <cassert>
#include <cstdio>
#include <utility>

#include "firmware/protocol/crc32c.h"

namespace stria {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'S', 'T', 'R', 'I'};

void put16(std::uint8_t* out, std::uint16_t value) {
    out[0] = static_cast<std::uint8_t>(value);
    out[1] = static_cast<std::uint8_t>(value >> 8);
}
void put32(std::uint8_t* out, std::uint32_t value) {
    put16(out, static_cast<std::uint16_t>(value));
    put16(out + 2, static_cast<std::uint16_t>(value >> 16));
}
std::uint16_t get16(const std::uint8_t* in) {
    return static_cast<std::uint16_t>(in[0] | (in[1] << 8));
}
std::uint32_t get32(const std::uint8_t* in) {
    return get16(in) | (static_cast<std::uint32_t>(get16(in + 2)) << 16);
}

bool is_known(std::uint16_t type) { return (type >= 1 && type <= 7) || type == 16 || type == 17; }

Failure bad(std::size_t byte, const char* what, const char* expected, std::uint32_t found) {
    char text[160];
    std::snprintf(text, sizeof text, "message header: %s: expected %s, found %u", what, expected,
                  found);
    return {text, byte};
}

}  // namespace

std::array<std::uint8_t, kHeaderBytes> encode_header(const MessageHeader& header) {
    std::array<std::uint8_t, kHeaderBytes> bytes{};
    std::copy(kMagic.begin(), kMagic.end(), bytes.begin());
    put16(&bytes[4], kProtocolVersion);
    bytes[6] = static_cast<std::uint8_t>(header.channel);
    put16(&bytes[8], static_cast<std::uint16_t>(header.type));
    put32(&bytes[12], header.length);
    put32(&bytes[16], header.session);
    put32(&bytes[20], header.sequence);
    put32(&bytes[24], header.payload_crc);
    put32(&bytes[28], crc32c({bytes.data(), 28}));
    return bytes;
}

Result<MessageHeader> decode_header(std::span<const std::uint8_t, kHeaderBytes> bytes) {
    if (!std::equal(kMagic.begin(), kMagic.end(), bytes.begin()))
        return bad(0, "magic", "\"STRI\" (1230132307)", get32(&bytes[0]));
    if (get32(&bytes[28]) != crc32c(bytes.first<28>()))
        return bad(28, "header CRC-32C", "that of bytes 0-27", get32(&bytes[28]));
    const std::uint16_t version = get16(&bytes[4]);
    if (version != kProtocolVersion) return bad(4, "version", "1", version);
    if (bytes[7] != 0 || get16(&bytes[10]) != 0) return bad(7, "reserved bytes", "0", bytes[7]);
    if (bytes[6] > 2) return bad(6, "channel", "0, 1 or 2", bytes[6]);
    const std::uint16_t type = get16(&bytes[8]);
    if (!is_known(type)) return bad(8, "type", "1 to 7, 16 or 17", type);
    MessageHeader header;
    header.channel = static_cast<WireChannel>(bytes[6]);
    header.type = static_cast<MessageType>(type);
    header.length = get32(&bytes[12]);
    header.session = get32(&bytes[16]);
    header.sequence = get32(&bytes[20]);
    header.payload_crc = get32(&bytes[24]);
    if (header.length > kMaxPayloadBytes)
        return bad(12, "length", "at most 67108864", header.length);
    return header;
}

Status check_payload(const MessageHeader& header, std::span<const std::uint8_t> payload) {
    if (payload.size() != header.length)
        return Failure{"message payload: expected " + std::to_string(header.length) +
                       " bytes, found " + std::to_string(payload.size())};
    if (crc32c(payload) != header.payload_crc)
        return Failure{"message payload: its CRC-32C is not the header's (damaged bytes)"};
    return {};
}

RawMessage make_raw(WireChannel channel, MessageType type, Bytes payload, std::uint32_t session,
                    std::uint32_t sequence) {
    assert(payload.size() <= kMaxPayloadBytes);
    RawMessage message;
    message.header = {.channel = channel,
                      .type = type,
                      .length = static_cast<std::uint32_t>(payload.size()),
                      .session = session,
                      .sequence = sequence,
                      .payload_crc = crc32c(payload)};
    message.payload = std::move(payload);
    return message;
}

}  // namespace stria

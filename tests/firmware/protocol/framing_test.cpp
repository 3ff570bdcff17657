#include "firmware/protocol/framing.h"

#include <gtest/gtest.h>

#include "firmware/protocol/crc32c.h"

namespace stria {
namespace {

using HeaderBytes = std::array<std::uint8_t, kHeaderBytes>;

MessageHeader some_header() {
    return {.channel = WireChannel::health,
            .type = MessageType::health,
            .length = 0x01020304,
            .session = 0x11121314,
            .sequence = 0x21222324,
            .payload_crc = 0x31323334};
}

/// The header with byte `at` changed and its CRC made right again.
HeaderBytes forged(std::size_t at, std::uint8_t value) {
    HeaderBytes bytes = encode_header(some_header());
    bytes[at] = value;
    const std::uint32_t crc = crc32c({bytes.data(), 28});
    for (std::size_t i = 0; i < 4; ++i) bytes[28 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
    return bytes;
}

TEST(Framing, HeaderReturnsAsItWas) {
    const auto decoded = decode_header(encode_header(some_header()));
    ASSERT_TRUE(decoded) << decoded.failure().message;
    EXPECT_EQ(*decoded, some_header());
}

// Bytes that recordings of version 1 hold, for ever; the CRC by a bitwise program in Python.
TEST(Framing, HeaderHasItsGoldenBytes) {
    const HeaderBytes golden = {0x53, 0x54, 0x52, 0x49, 0x01, 0x00, 0x02, 0x00, 0x06, 0x00, 0x00,
                                0x00, 0x04, 0x03, 0x02, 0x01, 0x14, 0x13, 0x12, 0x11, 0x24, 0x23,
                                0x22, 0x21, 0x34, 0x33, 0x32, 0x31, 0x4F, 0xE4, 0x7E, 0xDE};
    EXPECT_EQ(encode_header(some_header()), golden);
}

TEST(Framing, EveryFlippedBitOfAHeaderIsNoticed) {
    const HeaderBytes right = encode_header(some_header());
    for (std::size_t bit = 0; bit < 8 * kHeaderBytes; ++bit) {
        HeaderBytes bytes = right;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << (bit % 8)));
        EXPECT_FALSE(decode_header(bytes)) << "bit " << bit;
    }
}

TEST(Framing, RefusesWhatItDoesNotKnowEvenWithARightCrc) {
    EXPECT_EQ(decode_header(forged(4, 2)).failure().byte_offset, 4U);    // version
    EXPECT_EQ(decode_header(forged(6, 3)).failure().byte_offset, 6U);    // channel
    EXPECT_EQ(decode_header(forged(7, 1)).failure().byte_offset, 7U);    // reserved
    EXPECT_EQ(decode_header(forged(8, 8)).failure().byte_offset, 8U);    // type
    EXPECT_EQ(decode_header(forged(15, 5)).failure().byte_offset, 12U);  // 80 MiB
}

TEST(Framing, PayloadMustHaveItsLengthAndCrc) {
    RawMessage message = make_raw(WireChannel::data, MessageType::end, {1, 2, 3}, 7, 8);
    EXPECT_TRUE(check_payload(message.header, message.payload));
    message.payload[1] ^= 4;
    EXPECT_FALSE(check_payload(message.header, message.payload));
    message.payload = {1, 2};
    EXPECT_FALSE(check_payload(message.header, message.payload));
}

}  // namespace
}  // namespace stria

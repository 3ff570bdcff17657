#include "firmware/protocol/crc32c.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

namespace stria {
namespace {

using ByteVector = std::vector<std::uint8_t>;

void expect_crc(const ByteVector& bytes, std::uint32_t crc) {
    EXPECT_EQ(crc32c(bytes), crc);
    EXPECT_EQ(crc32c_by_tables(bytes), crc);
}

// RFC 3720, B.4 (the RFC prints the bytes in the order they are sent: 32 zeros, aa 36 91 8a).
TEST(Crc32c, EqualsTheVectorsOfRfc3720) {
    expect_crc(ByteVector(32, 0x00), 0x8A9136AAU);
    expect_crc(ByteVector(32, 0xFF), 0x62A8AB43U);
    ByteVector ascending(32), descending(32);
    std::iota(ascending.begin(), ascending.end(), std::uint8_t{0});
    std::iota(descending.rbegin(), descending.rend(), std::uint8_t{0});
    expect_crc(ascending, 0x46DD794EU);
    expect_crc(descending, 0x113FDB5CU);
    ByteVector read10(48, 0);  // an iSCSI SCSI Read (10) command
    read10[0] = 0x01;
    read10[1] = 0xC0;
    read10[16] = 0x14;
    read10[22] = 0x04;
    read10[27] = 0x14;
    read10[31] = 0x18;
    read10[32] = 0x28;
    read10[40] = 0x02;
    expect_crc(read10, 0xD9963A56U);
}

TEST(Crc32c, OfNothingIsZero) { expect_crc({}, 0U); }

TEST(Crc32c, ContinuesWhereItStopped) {
    std::mt19937 rng(5);
    ByteVector bytes(1000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(rng());
    const std::span<const std::uint8_t> all(bytes);
    for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
        const std::uint32_t first = crc32c(all.first(cut));
        ASSERT_EQ(crc32c(all.subspan(cut), first), crc32c(all)) << cut;
        ASSERT_EQ(crc32c_by_tables(all.subspan(cut), first), crc32c(all)) << cut;
    }
}

}  // namespace
}  // namespace stria

#include "firmware/protocol/pulse_bands.h"

#include <gtest/gtest.h>

#include "tests/firmware/protocol/samples.h"

namespace stria {
namespace {

TEST(PulseBands, PutTogetherAgainTheyAreTheMap) {
    const PulseMap map = samples::pulse_map(20, 31);
    for (std::size_t max_bytes : {std::size_t{1}, std::size_t{5000}, std::size_t{1} << 30}) {
        PulseMapAssembler assembler;
        std::optional<PulseMap> whole;
        const auto bands = split_into_bands(map, max_bytes);
        for (const PulseBand& band : bands) {
            EXPECT_FALSE(whole);
            EXPECT_TRUE(is_valid(band.map));
            whole = assembler.add(band);
        }
        ASSERT_TRUE(whole);
        EXPECT_EQ(whole->cell_begin, map.cell_begin);
        EXPECT_EQ(whole->pulses.size(), map.pulses.size());
        EXPECT_EQ(whole->height, 31);
        if (max_bytes == 1) {
            EXPECT_EQ(bands.size(), 31U);
        }
        EXPECT_TRUE(assembler.is_empty());
    }
}

TEST(PulseBands, StayWithinTheirBytes) {
    const PulseMap map = samples::pulse_map(20, 31);
    for (const PulseBand& band : split_into_bands(map, 9000)) {
        EXPECT_LE(band.map.pulses.size() * sizeof(Pulse) + band.map.cell_begin.size() - 1, 9000U);
    }
}

TEST(PulseBands, AMapWithoutItsLastBandKeepsTheOthers) {
    const PulseMap map = samples::pulse_map(20, 31);
    auto bands = split_into_bands(map, 9000);
    ASSERT_GT(bands.size(), 2U);
    const int rows = bands.back().first_row;
    bands.pop_back();
    PulseMapAssembler assembler;
    for (const PulseBand& band : bands) EXPECT_FALSE(assembler.add(band));
    const auto part = assembler.unfinished();
    ASSERT_TRUE(part);
    EXPECT_TRUE(is_valid(*part));
    EXPECT_EQ(part->height, 31);
    EXPECT_EQ(part->pulses.size(), map.cell_begin[static_cast<std::size_t>(rows) * 20]);
    EXPECT_TRUE(part->cell(0, 30).empty());
}

TEST(PulseBands, ABandWhoseBeginningIsMissingIsNoMap) {
    const auto bands = split_into_bands(samples::pulse_map(20, 31), 9000);
    PulseMapAssembler assembler;
    EXPECT_FALSE(assembler.add(bands.back()));
    EXPECT_FALSE(assembler.unfinished());
}

}  // namespace
}  // namespace stria

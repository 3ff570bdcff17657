#include "sim/blooming.h"

#include <algorithm>
#include <cstddef>

namespace stria {
namespace {

/// One way along the row; `at(i)` is its i-th pixel.
template <typename Pixel>
void spill(std::size_t count, const Pixel& at, float full_well_e, float blooming) {
    float packet = 0;
    for (std::size_t i = 0; i < count; ++i) {
        float& electrons = at(i);
        packet *= blooming;
        if (electrons > full_well_e) {
            packet += (electrons - full_well_e) / 2;
            continue;
        }
        const float taken = std::min(packet, full_well_e - electrons);
        electrons += taken;
        packet -= taken;
    }
}

}  // namespace

void spill_along_row(std::span<float> row, float full_well_e, float blooming) {
    spill(
        row.size(), [&](std::size_t i) -> float& { return row[i]; }, full_well_e, blooming);
    spill(
        row.size(), [&](std::size_t i) -> float& { return row[row.size() - 1 - i]; }, full_well_e,
        blooming);
}

}  // namespace stria

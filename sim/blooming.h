#pragma once
#include <span>

namespace stria {

/// Charge above the full well spills along the row, half of it to each side: a pixel on the way
/// takes what it has room for, and of the rest the share `blooming` goes on to the next, what is
/// left runs off. With blooming = 1 no electron is lost short of the row's ends. Pixels that spill
/// keep what they had: the converter cuts them at the full well.
/// @param row  electrons of one row, in place
void spill_along_row(std::span<float> row, float full_well_e, float blooming);

}  // namespace stria

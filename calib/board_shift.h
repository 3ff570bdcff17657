#pragma once
#include <optional>

#include "calib/detect_board.h"

namespace stria {

/// More than corners scatter between two pictures of a board at rest (0.02 to 0.1 px, 0.2 px in
/// JPEG with other light), and about where a stripe on a moved board would mislead.
constexpr double kMovedPx = 0.5;

/// How far (px, median over the points both show) a board moved from one picture to another; empty
/// if fewer than 4 points are in both. Points that a board which looks the same turned numbers the
/// other way round are matched as they lie.
std::optional<double> board_shift_px(const Detection& before, const Detection& after);

}  // namespace stria

#pragma once
#include <string>
#include <vector>

#include "calib/camera_calibration.h"

namespace stria {

/// Corners found elsewhere: lines "view row col x y weight" (weight may be missing: 1; <= 0:
/// rejected), '#' starts a comment. Views are named by their first column and need not be in order.
/// Throws FileError with the line where a line does not read, a row or column is not on the board,
/// a corner comes twice, or there is no corner.
std::vector<CameraView> read_corner_table(const std::string& path, const Board& board);

}  // namespace stria

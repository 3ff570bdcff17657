#pragma once
#include <Eigen/Core>

#include "host/core/board.h"
#include "host/core/image.h"

namespace stria {

/// The board as a picture: black 0, white 255, grey where an edge crosses a pixel (its area share),
/// with a white margin all round. Board x points right, y down. Size: (pattern_size_mm + 2 margin)
/// times px_per_mm, rounded up. Throws std::invalid_argument if px_per_mm is not above 0, the
/// margin is negative or a side would exceed 20000 px; stria::Error as board_shapes() does.
GreyImage draw_board(const Board& board, double px_per_mm, double margin_mm);

/// Pixel of the board frame's origin in that picture, (0, 0) being the centre of the upper left
/// pixel: the board point (x, y, 0) mm is at board_origin_px + px_per_mm (x, y).
Eigen::Vector2d board_origin_px(const Board& board, double px_per_mm, double margin_mm);

/// Board frame point (mm) of the picture's upper left corner (not pixel centre): where a texture's
/// outer corner has to lie. The picture spans picture_size_mm() from there.
Eigen::Vector2d picture_corner_mm(const Board& board, double margin_mm);
/// Width and height of what the picture shows, rounding up included.
Eigen::Vector2d picture_size_mm(const Board& board, double px_per_mm, double margin_mm);

}  // namespace stria

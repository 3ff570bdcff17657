#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "host/core/board.h"
#include "host/core/image.h"

namespace stria {

/// Feature points of a board as seen in one image.
struct Detection {
    std::vector<int> ids;                 ///< into board_points(), ascending
    std::vector<Eigen::Vector2d> pixels;  ///< same order; (0, 0) is the centre of the first pixel
    std::string refusal;                  ///< empty if found, else why not, in words

    bool found() const { return refusal.empty(); }
};

/// Finds the board in a grey image and refines its points to sub-pixel precision: chessboards and
/// circle grids whole or not at all, ChArUco boards from 6 corners on. Points are numbered as
/// board_points() does, never mirrored. A chessboard that looks the same after half a turn (see
/// looks_same_turned) and every circle grid may come out turned in its plane. Refuses with a
/// reason that begins with its name: "not found", "too few corners", "blur", "glare", "too
/// oblique", "wrong board" (columns and rows swapped, another size, another dictionary, a pattern
/// that goes on); looking for the reason takes some times as long as finding a board. Circle
/// centres are those of the discs' images, which tilt moves slightly: prefer chessboards. Throws
/// stria::Error on an unknown dictionary, std::invalid_argument on an image that is empty or has
/// more than one channel.
Detection detect_board(const GreyImage& image, const Board& board);

/// True if the board cannot be told from itself turned by 180 (or 90) degrees: circle grids, and
/// chessboards whose numbers of inner corners are both even or both odd.
bool looks_same_turned(const Board& board);

}  // namespace stria

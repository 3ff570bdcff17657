#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/core/board.h"

namespace stria {

/// An axis-parallel black rectangle of a board, mm, board frame.
struct BoardRect {
    double x = 0, y = 0;  ///< corner with the smallest coordinates
    double width = 0, height = 0;
};

/// A black disc of a board, mm, board frame.
struct BoardDisc {
    double x = 0, y = 0;
    double radius = 0;
};

/// A board as black shapes on white; rectangles do not overlap, discs do not touch.
struct BoardShapes {
    std::vector<BoardRect> rects;
    std::vector<BoardDisc> discs;
    Eigen::Vector2d min_mm = Eigen::Vector2d::Zero();  ///< upper left of the pattern, board frame
    Eigen::Vector2d max_mm = Eigen::Vector2d::Zero();  ///< lower right
};

/// The shapes of a board. Chessboards and ChArUco boards have a black square at the upper left;
/// ChArUco markers are those of OpenCV 4.6 (ids by rows, in the white squares); discs of circle
/// grids have half the pitch as diameter. Throws stria::Error on an unknown dictionary, naming the
/// known ones, and when the dictionary has too few markers for the board.
BoardShapes board_shapes(const Board& board);

}  // namespace stria

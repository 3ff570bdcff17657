#include "calib/board_shapes.h"

#include "calib/aruco_dictionary.h"

namespace stria {
namespace {

void add_black_squares(BoardShapes& shapes, int columns, int rows, double side, double origin) {
    for (int row = 0; row < rows; ++row)
        for (int column = row % 2; column < columns; column += 2)
            shapes.rects.push_back({origin + column * side, origin + row * side, side, side});
}

/// Marker `id` with its upper left at (x, y): black border one bit wide, runs of black bits.
void add_marker(BoardShapes& shapes, const cv::aruco::Dictionary& dictionary, int id, double x,
                double y, double side) {
    const int bits = dictionary.markerSize;
    const cv::Mat pattern =
        cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.rowRange(id, id + 1), bits);
    const double cell = side / (bits + 2);
    const auto is_black = [&](int row, int column) {
        if (row < 0 || column < 0 || row >= bits || column >= bits) return true;
        return pattern.at<std::uint8_t>(row, column) == 0;
    };
    for (int row = -1; row <= bits; ++row)
        for (int first = -1; first <= bits; ++first) {
            if (!is_black(row, first)) continue;
            int end = first + 1;
            while (end <= bits && is_black(row, end)) ++end;
            shapes.rects.push_back(
                {x + (first + 1) * cell, y + (row + 1) * cell, (end - first) * cell, cell});
            first = end;  // the bit at `end` is white
        }
}

void add_markers(BoardShapes& shapes, const Board& board) {
    const auto drawn = charuco_board(board);
    const double inset = 0.5 * (board.pitch_mm - board.marker_mm);
    int id = 0;
    for (int row = 0; row < board.rows; ++row)
        for (int column = 1 - row % 2; column < board.columns; column += 2)
            add_marker(shapes, *drawn->dictionary, id++, column * board.pitch_mm + inset,
                       row * board.pitch_mm + inset, board.marker_mm);
}

}  // namespace

BoardShapes board_shapes(const Board& board) {
    BoardShapes shapes;
    switch (board.kind) {
        case BoardKind::chessboard:
            add_black_squares(shapes, board.columns + 1, board.rows + 1, board.pitch_mm,
                              -board.pitch_mm);
            shapes.min_mm.setConstant(-board.pitch_mm);
            break;
        case BoardKind::charuco:
            add_black_squares(shapes, board.columns, board.rows, board.pitch_mm, 0);
            add_markers(shapes, board);
            break;
        case BoardKind::circles:
        case BoardKind::acircles:
            for (const Eigen::Vector3d& centre : board_points(board))
                shapes.discs.push_back({centre.x(), centre.y(), 0.25 * board.pitch_mm});
            shapes.min_mm.setConstant(-0.5 * board.pitch_mm);
            break;
    }
    shapes.max_mm = shapes.min_mm + pattern_size_mm(board);
    return shapes;
}

}  // namespace stria

#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace stria {

enum class BoardKind : std::uint8_t { chessboard, charuco, circles, acircles };

/// A flat calibration target. Frame: origin at the first inner corner (chessboard), circle centre
/// (grids) or the outer corner of square 0 (ChArUco), x along columns, y along rows, z away from
/// the viewer. Sizes in mm.
struct Board {
    BoardKind kind = BoardKind::chessboard;
    int columns = 0;  ///< inner corners; ChArUco: squares; grids: circles
    int rows = 0;
    double pitch_mm = 0;     ///< square side or circle pitch
    double marker_mm = 0;    ///< ChArUco marker side
    std::string dictionary;  ///< ChArUco, as "DICT_6X6_250"
};

/// Reads "chessboard:9x6:25", "charuco:7x5:20:10:DICT_6X6_250", "circles:7x7:37.5",
/// "acircles:4x11:20". Throws stria::Error that says which part is wrong and shows a right one.
Board parse_board(const std::string& text);
std::string to_string(const Board& board);

/// Feature points in the board frame by id: corner id = row x columns + column. ChArUco: the
/// (columns - 1) x (rows - 1) inner corners. Asymmetric grids as OpenCV lays them: odd rows moved
/// by half a pitch: x = (2 column + row % 2) pitch, y = row pitch.
std::vector<Eigen::Vector3d> board_points(const Board& board);

/// Width and height (mm) of the printed pattern, margins left out.
Eigen::Vector2d pattern_size_mm(const Board& board);

}  // namespace stria

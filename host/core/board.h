#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace stria {

enum class BoardKind : std::uint8_t { chessboard, charuco, circles, acircles };

/// A calibration target, flat but for its warp. Frame: origin at the first inner corner
/// (chessboard), circle centre (grids) or the outer corner of square 0 (ChArUco), x along columns,
/// y along rows, z away from the viewer. Sizes in mm.
struct Board {
    BoardKind kind = BoardKind::chessboard;
    int columns = 0;  ///< inner corners; ChArUco: squares; grids: circles
    int rows = 0;
    double pitch_mm = 0;     ///< square side or circle pitch
    double marker_mm = 0;    ///< ChArUco marker side
    std::string dictionary;  ///< ChArUco, as "DICT_6X6_250"
    /// How far the board bulges: BoardRise . warp_mm is the height (z) of its surface. Measured,
    /// not printed: no part of its text.
    Eigen::Vector2d warp_mm = Eigen::Vector2d::Zero();
};

/// Reads "chessboard:9x6:25", "charuco:7x5:20:10:DICT_6X6_250", "circles:7x7:37.5",
/// "acircles:4x11:20". Throws stria::Error that says which part is wrong and shows a right one.
Board parse_board(const std::string& text);
std::string to_string(const Board& board);

/// Feature points in the board frame by id: corner id = row x columns + column. ChArUco: the
/// (columns - 1) x (rows - 1) inner corners. Asymmetric grids as OpenCV lays them: odd rows moved
/// by half a pitch: x = (2 column + row % 2) pitch, y = row pitch.
std::vector<Eigen::Vector3d> board_points(const Board& board);

/// The same board, bulging like that.
Board with_warp(Board board, const Eigen::Vector2d& warp_mm);

/// (1 - gx^2, 1 - gy^2) at a place of the board (mm), g running from -1 to 1 over its points: the
/// two shapes that a board bulges in.
class BoardRise {
  public:
    /// @param points  all of board_points()
    explicit BoardRise(const std::vector<Eigen::Vector3d>& points);
    Eigen::Vector2d at(const Eigen::Vector2d& on_board) const;

  private:
    Eigen::Vector2d middle_, half_;
};

/// Width and height (mm) of the printed pattern, margins left out.
Eigen::Vector2d pattern_size_mm(const Board& board);

}  // namespace stria

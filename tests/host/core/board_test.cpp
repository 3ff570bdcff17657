#include "host/core/board.h"

#include <gtest/gtest.h>

#include "host/core/errors.h"

namespace stria {
namespace {

TEST(Board, ReadsItsFourKindsAndWritesThemBack) {
    for (const std::string text : {"chessboard:9x6:25", "charuco:7x5:20:10:DICT_6X6_250",
                                   "circles:7x7:37.5", "acircles:4x11:20.25"})
        EXPECT_EQ(to_string(parse_board(text)), text);
    const Board board = parse_board("charuco:7x5:20:10:DICT_6X6_250");
    EXPECT_EQ(board.columns, 7);
    EXPECT_EQ(board.rows, 5);
    EXPECT_EQ(board.pitch_mm, 20);
    EXPECT_EQ(board.marker_mm, 10);
    EXPECT_EQ(board.dictionary, "DICT_6X6_250");
}

TEST(Board, SaysWhichPartIsWrongAndShowsARightOne) {
    const auto message = [](const std::string& text) -> std::string {
        try {
            parse_board(text);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    };
    for (const std::string text :
         {"", "chess:9x6:25", "chessboard", "chessboard:9x6", "chessboard:9:25",
          "chessboard:9x6x2:25", "chessboard:1x6:25", "chessboard:201x6:25", "chessboard:-9x6:25",
          "chessboard:9x6:0", "chessboard:9x6:-1", "chessboard:9x6:nan", "chessboard:9x6:25mm",
          "charuco:7x5:20:10", "charuco:7x5:20:20:DICT_6X6_250", "charuco:7x5:20:10:6X6",
          "circles:7x7:37.5:1"})
        EXPECT_NE(message(text).find("expected chessboard:COLSxROWS:SQUARE_MM"), std::string::npos)
            << text;
    EXPECT_NE(message("chessboard:9x6:25mm").find("\"25mm\" is no length"), std::string::npos);
}

TEST(Board, NumbersItsPointsRowByRow) {
    const auto chess = board_points(parse_board("chessboard:3x2:10"));
    ASSERT_EQ(chess.size(), 6U);
    EXPECT_EQ(chess[0], Eigen::Vector3d(0, 0, 0));
    EXPECT_EQ(chess[4], Eigen::Vector3d(10, 10, 0));  // row 1, column 1
    // ChArUco counts squares and starts at the outer corner of square 0.
    const auto charuco = board_points(parse_board("charuco:4x3:10:5:DICT_4X4_50"));
    ASSERT_EQ(charuco.size(), 6U);
    EXPECT_EQ(charuco[0], Eigen::Vector3d(10, 10, 0));
    EXPECT_EQ(charuco[5], Eigen::Vector3d(30, 20, 0));
    // Asymmetric grids as OpenCV's sample lays them: (2 j + i % 2) d, i d.
    const auto grid = board_points(parse_board("acircles:4x11:20"));
    ASSERT_EQ(grid.size(), 44U);
    EXPECT_EQ(grid[0], Eigen::Vector3d(0, 0, 0));
    EXPECT_EQ(grid[5], Eigen::Vector3d(60, 20, 0));  // row 1, column 1
}

TEST(Board, KnowsTheSizeOfItsPattern) {
    EXPECT_EQ(pattern_size_mm(parse_board("chessboard:9x6:25")), Eigen::Vector2d(250, 175));
    EXPECT_EQ(pattern_size_mm(parse_board("charuco:7x5:20:10:DICT_6X6_250")),
              Eigen::Vector2d(140, 100));
    EXPECT_EQ(pattern_size_mm(parse_board("circles:7x6:10")), Eigen::Vector2d(70, 60));
}

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "calib/detect_board.h"
#include "tests/calib/photographed_board.h"

/// Every way a view can be spoilt, for every kind of board: the reason named is the one injected.
namespace stria {
namespace {

/// @param finer  times as many pixels along each side
CameraModel camera(int finer) {
    CameraModel camera;
    camera.width = 480 * finer;
    camera.height = 360 * finer;
    camera.fx = camera.fy = 520 * finer;
    camera.cx = 240 * finer - 0.5;
    camera.cy = 180 * finer - 0.5;
    return camera;
}

const std::vector<std::string> kBoards = {"chessboard:9x6:14", "charuco:8x6:18:13:DICT_5X5_100",
                                          "circles:7x6:20", "acircles:4x7:20"};

struct Case {
    std::string name;
    Eigen::Vector3d centre = {0, 0, 300};
    Eigen::Vector3d turn = {0.2, -0.15, 0.1};
    PhotographOptions options = {};
    int finer = 1;
};

std::string refusal(const std::string& expected, const std::string& shown, const Case& seen) {
    const Board board = parse_board(shown);
    const Rigid3 pose = board_at(board, seen.centre, seen.turn);
    const GreyImage picture = grey_photograph(camera(seen.finer), pose, board, seen.options);
    return detect_board(picture, parse_board(expected)).refusal;
}

void expect_named(const Case& seen, const std::string& board) {
    const std::string why = refusal(board, board, seen);
    EXPECT_EQ(why.rfind(seen.name + ":", 0), 0u)
        << board << ", injected \"" << seen.name << "\", said \"" << why << '"';
}

TEST(Refusals, NoneForAGoodView) {
    for (const std::string& board : kBoards) EXPECT_EQ(refusal(board, board, {}), "") << board;
}

TEST(Refusals, NameBlur) {
    for (const std::string& board : kBoards)
        expect_named({.name = "blur", .options = {.blur_px = 5.5}}, board);
}

TEST(Refusals, NameGlare) {
    // On a ChArUco board glare is only a reason where it leaves fewer corners than are needed.
    for (const std::string& board : kBoards) {
        const bool charuco = parse_board(board).kind == BoardKind::charuco;
        expect_named({.name = "glare",
                      .options = {.glare_dn = charuco ? 1500.0 : 700.0,
                                  .glare_at = {265, 180},
                                  .glare_px = charuco ? 62.0 : 30.0}},
                     board);
    }
}

TEST(Refusals, NameObliqueViews) {
    // 78 deg; markers so flat are read in a finer picture only
    for (const std::string board : {"chessboard:9x6:14", "charuco:6x4:24:18:DICT_4X4_50",
                                    "circles:7x6:20", "acircles:4x7:20"})
        for (const Eigen::Vector3d& turn :
             {Eigen::Vector3d(1.36, 0, 0), Eigen::Vector3d(0, 1.36, 0)})
            expect_named({.name = "too oblique",
                          .centre = {0, 0, board[0] == 'a' ? 400.0 : 280.0},
                          .turn = turn,
                          .finer = board[0] == 'a' || board[1] == 'h' ? 2 : 1},
                         board);
}

TEST(Refusals, NameHiddenParts) {
    for (const std::string& board : kBoards) {
        const bool charuco = parse_board(board).kind == BoardKind::charuco;
        expect_named({.name = "too few corners",
                      .turn = {0.1, -0.1, 0},
                      .options = {.hidden_from = charuco ? 170.0 : 265.0}},
                     board);
    }
}

TEST(Refusals, NameAPictureWithoutBoard) {
    for (const std::string& board : kBoards)
        expect_named({.name = "not found", .centre = {900, 0, 300}}, board);
}

TEST(Refusals, NameTheBoardThatIsThere) {
    struct Wrong {
        std::string expected, shown, said;
    };
    std::vector<Wrong> table = {
        {"charuco:5x7:20:14:DICT_6X6_250", "charuco:7x5:20:14:DICT_6X6_250",
         "7 x 5 squares, expected 5 x 7 squares: columns and rows are swapped"},
        {"charuco:8x6:18:13:DICT_5X5_100", "charuco:8x6:18:13:DICT_4X4_50",
         "markers are of DICT_4X4_50, expected DICT_5X5_100"},
        {"chessboard:9x6:14", "chessboard:8x6:14", "8 x 6 inner corners, expected 9 x 6"},
        {"circles:6x5:20", "circles:8x4:18", "symmetric grid of 8 x 4"},
        {"acircles:4x7:20", "acircles:4x9:16", "asymmetric grid of 4 x 9"},
        {"charuco:7x5:20:14:DICT_6X6_250", "charuco:5x7:20:14:DICT_6X6_250",
         "5 x 7 squares, expected 7 x 5 squares: columns and rows are swapped"},
        {"charuco:8x6:18:13:DICT_4X4_50", "charuco:8x6:18:13:DICT_7X7_250",
         "markers are of DICT_7X7_50, expected DICT_4X4_50"},
        {"charuco:9x6:18:13:DICT_5X5_100", "charuco:8x6:18:13:DICT_5X5_100", "8 columns"},
        {"charuco:8x6:18:13:DICT_5X5_100", "charuco:9x6:18:13:DICT_5X5_100", "9 columns"},
        {"chessboard:8x6:14", "chessboard:9x6:14", "9 x 6 inner corners, expected 8 x 6"},
        {"chessboard:9x6:14", "chessboard:7x5:14", "7 x 5 inner corners, expected 9 x 6"},
        {"circles:6x5:20", "circles:7x6:20", "wrong board"},
        {"acircles:4x7:20", "acircles:5x7:18", "asymmetric grid of 5 x 7"},
        {"acircles:4x7:20", "circles:7x6:20", "a symmetric grid of 6 x 7"},
        {"acircles:7x4:18", "acircles:4x7:20", "columns and rows are swapped"},
    };
    table.resize(std::min<std::size_t>(table.size(), STRIA_WRONG_BOARDS));
    for (const Wrong& wrong : table) {
        EXPECT_EQ(refusal(wrong.shown, wrong.shown, {.name = "", .turn = {0.1, -0.1, 0.05}}), "")
            << wrong.shown;
        const std::string why =
            refusal(wrong.expected, wrong.shown, {.name = "", .turn = {0.1, -0.1, 0.05}});
        EXPECT_EQ(why.rfind("wrong board: ", 0), 0u)
            << wrong.shown << " as " << wrong.expected << ": " << why;
        EXPECT_NE(why.find(wrong.said), std::string::npos)
            << wrong.shown << " as " << wrong.expected << ": " << why;
    }
}

TEST(Refusals, DoNotCallAPartOfTheBoardAnotherOne) {
    const std::string why =
        refusal("circles:7x6:20", "circles:6x5:20", {.name = "", .turn = {0.1, -0.1, 0.05}});
    EXPECT_EQ(why.rfind("too few corners: ", 0), 0u) << why;
    EXPECT_NE(why.find("6 x 5"), std::string::npos) << why;
    EXPECT_NE(why.find("smaller one"), std::string::npos) << why;
}

}  // namespace
}  // namespace stria

#include "calib/board_drawing.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>
#include <opencv2/aruco/charuco.hpp>
#include <stdexcept>

#include "host/core/errors.h"

namespace stria {
namespace {

TEST(BoardDrawing, ShowsTheChessboardsOriginWhereItSays) {
    const Board board = parse_board("chessboard:3x2:10");
    const GreyImage picture = draw_board(board, 4, 5);
    ASSERT_EQ(picture.width, (4 * 10 + 2 * 5) * 4);
    ASSERT_EQ(picture.height, (3 * 10 + 2 * 5) * 4);
    const Eigen::Vector2d origin = board_origin_px(board, 4, 5);
    EXPECT_DOUBLE_EQ(origin.x(), 59.5);  // 15 mm, half a pixel back from the border to the centre
    const int x = static_cast<int>(origin.x()), y = static_cast<int>(origin.y());
    EXPECT_EQ(picture.at(x, y), 0);  // black at the upper left of the first corner
    EXPECT_EQ(picture.at(x + 1, y), 255);
    EXPECT_EQ(picture.at(x, y + 1), 255);
    EXPECT_EQ(picture.at(x + 1, y + 1), 0);
    EXPECT_EQ(picture.at(0, 0), 255);  // the margin
}

TEST(BoardDrawing, DrawsCharucoBoardsAsOpenCvDoes) {
    for (const char* text : {"charuco:7x5:20:10:DICT_6X6_250", "charuco:6x8:16:12:DICT_4X4_50",
                             "charuco:5x7:18:9:DICT_5X5_100"}) {
        const Board board = parse_board(text);
        const double px_per_mm = board.dictionary == "DICT_6X6_250" ? 4 : 14.0 / 3.0;
        const GreyImage ours = draw_board(board, px_per_mm, 0);
        cv::aruco::PREDEFINED_DICTIONARY_NAME name = cv::aruco::DICT_6X6_250;
        if (board.dictionary == "DICT_4X4_50") name = cv::aruco::DICT_4X4_50;
        if (board.dictionary == "DICT_5X5_100") name = cv::aruco::DICT_5X5_100;
        const auto peer = cv::aruco::CharucoBoard::create(
            board.columns, board.rows, static_cast<float>(board.pitch_mm),
            static_cast<float>(board.marker_mm), cv::aruco::getPredefinedDictionary(name));
        cv::Mat theirs;
        peer->draw(cv::Size(ours.width, ours.height), theirs, 0, 1);
        int different = 0;
        for (int y = 0; y < ours.height; ++y)
            for (int x = 0; x < ours.width; ++x)
                if (std::abs(int(ours.at(x, y)) - int(theirs.at<std::uint8_t>(y, x))) > 128)
                    ++different;
        // OpenCV shrinks markers to whole pixels: up to one pixel at the borders of bits.
        EXPECT_LT(different, 0.03 * ours.width * ours.height) << text;
    }
}

TEST(BoardDrawing, GivesDiscsTheirArea) {
    const Board board = parse_board("circles:5x4:9.3");
    const double px_per_mm = 3.7;
    const GreyImage picture = draw_board(board, px_per_mm, 2);
    double black = 0;
    for (std::uint8_t value : picture.values) black += 1.0 - value / 255.0;
    const double radius = 0.25 * 9.3 * px_per_mm;
    const double area = 20 * std::numbers::pi * radius * radius;
    EXPECT_NEAR(black, area, 1e-3 * area);  // px, rounding to 8 bits
}

TEST(BoardDrawing, RefusesWhatItCannotDraw) {
    const Board board = parse_board("chessboard:9x6:25");
    EXPECT_THROW(draw_board(board, 0, 1), std::invalid_argument);
    EXPECT_THROW(draw_board(board, 1, -1), std::invalid_argument);
    EXPECT_THROW(draw_board(board, 1000, 1), std::invalid_argument);
    EXPECT_THROW(draw_board(parse_board("charuco:7x5:20:10:DICT_9X9_1"), 1, 1), Error);
    EXPECT_THROW(draw_board(parse_board("charuco:20x20:20:10:DICT_4X4_50"), 1, 1), Error);
}

}  // namespace
}  // namespace stria

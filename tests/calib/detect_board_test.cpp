#include "calib/detect_board.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <iostream>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "calib/board_drawing.h"
#include "host/core/errors.h"

namespace stria {
namespace {

/// A picture of the board through a known homography, blurred a little, with noise; where its
/// points must be.
struct Scene {
    GreyImage image;
    std::vector<Eigen::Vector2d> truth;
};

Scene picture_of(const Board& board, std::mt19937& rng, double turn_rad) {
    std::uniform_real_distribution<double> unit(-1, 1);
    const double px_per_mm = 12;
    const GreyImage flat = draw_board(board, px_per_mm, 8);
    const Eigen::Vector2d origin = board_origin_px(board, px_per_mm, 8);
    const double scale = 620.0 / std::max(flat.width, flat.height);
    const double c = std::cos(turn_rad) * scale, s = std::sin(turn_rad) * scale;
    const double mx = 0.5 * flat.width, my = 0.5 * flat.height;
    const double tilt_x = 2.5e-5 * unit(rng), tilt_y = 2.5e-5 * unit(rng);
    const cv::Matx33d centre(1, 0, -mx, 0, 1, -my, 0, 0, 1);
    const cv::Matx33d tilted(c, -s, 0, s, c, 0, tilt_x, tilt_y, 1);
    const double right = 20 * unit(rng), down = 20 * unit(rng);
    const cv::Matx33d into(1, 0, 480 + right, 0, 1, 400 + down, 0, 0, 1);
    const cv::Matx33d h = into * tilted * centre;

    // Rendered four times as fine and averaged, so that edges are area-sampled.
    const cv::Matx33d fine(4, 0, 1.5, 0, 4, 1.5, 0, 0, 1);
    const cv::Mat source(flat.height, flat.width, CV_8UC1,
                         const_cast<std::uint8_t*>(flat.values.data()));
    cv::Mat large, small;
    cv::warpPerspective(source, large, fine * h, cv::Size(4 * 960, 4 * 800), cv::INTER_AREA,
                        cv::BORDER_CONSTANT, cv::Scalar(90));
    cv::GaussianBlur(large, large, cv::Size(0, 0), 2.8);  // 0.7 px in the picture
    cv::resize(large, small, cv::Size(960, 800), 0, 0, cv::INTER_AREA);

    Scene scene;
    scene.image = GreyImage(960, 800);
    std::normal_distribution<double> noise(0, 1.5);
    for (int y = 0; y < 800; ++y)
        for (int x = 0; x < 960; ++x)
            scene.image.at(x, y) = static_cast<std::uint8_t>(std::clamp(
                std::lround(20 + 0.8 * small.at<std::uint8_t>(y, x) + noise(rng)), 0L, 255L));
    for (const Eigen::Vector3d& p : board_points(board)) {
        const cv::Vec3d q =
            h * cv::Vec3d(origin.x() + px_per_mm * p.x(), origin.y() + px_per_mm * p.y(), 1);
        scene.truth.emplace_back(q[0] / q[2], q[1] / q[2]);
    }
    return scene;
}

TEST(DetectBoard, FindsEveryKindWhereItIsAndNumbersIt) {
    std::mt19937 rng(4);
    for (const char* text :
         {"chessboard:9x6:10", "chessboard:8x7:10", "charuco:9x7:12:9:DICT_5X5_100",
          "charuco:8x6:12:6:DICT_6X6_250", "acircles:4x11:9"}) {
        const Board board = parse_board(text);
        double sum = 0;
        int count = 0;
        for (double turn : {0.0, 0.4, 1.6, 3.0, -2.2}) {
            const Scene scene = picture_of(board, rng, turn);
            const Detection found = detect_board(scene.image, board);
            ASSERT_TRUE(found.found()) << text << " turned by " << turn << ": " << found.refusal;
            const double least = board.kind == BoardKind::charuco ? 0.9 : 1.0;
            EXPECT_GE(double(found.ids.size()), least * double(scene.truth.size()));
            for (std::size_t i = 0; i < found.ids.size(); ++i) {
                const auto id = static_cast<std::size_t>(found.ids[i]);
                const double error = (found.pixels[i] - scene.truth[id]).norm();
                // px: right number (neighbours are 40 px away), and sub-pixel; the tilt of discs
                // costs up to 0.1 px
                EXPECT_LT(error, 0.5) << text << " turn " << turn << " id " << id;
                sum += error * error;
                ++count;
            }
        }
        const double rms = std::sqrt(sum / count);
        std::cout << text << ": corner rms " << rms << " px\n";
        // px a corner (2-D): 0.05 px a coordinate is what good boards are said to give
        EXPECT_LT(rms, board.kind == BoardKind::acircles ? 0.15 : 0.07) << text;
    }
}

// In these pictures OpenCV's detector takes the edge of the outer squares for a line of corners.
TEST(DetectBoard, DoesNotTakeTheBoardsEdgeForCorners) {
    const Board board = parse_board("chessboard:8x7:10");
    for (const unsigned seed : {77U, 80U, 82U, 132U}) {
        std::mt19937 rng(seed);
        const double turn = std::uniform_real_distribution<double>(-3.14159, 3.14159)(rng);
        const Detection found = detect_board(picture_of(board, rng, turn).image, board);
        EXPECT_TRUE(found.found()) << seed << ": " << found.refusal;
    }
}

TEST(DetectBoard, KeepsSymmetricGridsRightHanded) {
    std::mt19937 rng(9);
    for (const char* text : {"circles:6x5:10", "chessboard:7x7:10"}) {
        const Board board = parse_board(text);
        for (double turn : {0.1, 1.7, 3.1}) {
            const Scene scene = picture_of(board, rng, turn);
            const Detection found = detect_board(scene.image, board);
            ASSERT_TRUE(found.found()) << text << ": " << found.refusal;
            const auto columns = static_cast<std::size_t>(board.columns);
            const Eigen::Vector2d x = found.pixels[columns - 1] - found.pixels[0];
            const Eigen::Vector2d y = found.pixels[found.pixels.size() - columns] - found.pixels[0];
            EXPECT_GT(x.x() * y.y() - x.y() * y.x(), 0) << text << " turn " << turn;
        }
    }
}

TEST(DetectBoard, FindsTheSameWhateverWasLookedAtBefore) {
    std::mt19937 rng(7);
    for (const char* text :
         {"chessboard:9x6:10", "charuco:9x7:12:9:DICT_5X5_100", "acircles:4x11:9"}) {
        const Board board = parse_board(text);
        const Scene scene = picture_of(board, rng, 0.3);
        const Detection first = detect_board(scene.image, board);
        ASSERT_TRUE(first.found()) << text << ": " << first.refusal;
        for (unsigned state = 1; state <= 2; ++state) {
            cv::theRNG() = cv::RNG(state);
            const Detection again = detect_board(scene.image, board);
            EXPECT_EQ(again.ids, first.ids) << text;
            EXPECT_EQ(again.pixels, first.pixels) << text;
            EXPECT_EQ(cv::theRNG().state, cv::RNG(state).state) << "the caller's generator";
        }
    }
}

TEST(DetectBoard, RefusesAPictureWithoutIt) {
    GreyImage grey(320, 240, 1, 128);
    for (const char* text : {"chessboard:9x6:10", "charuco:9x7:12:9:DICT_5X5_100", "circles:6x5:10",
                             "acircles:4x11:9"}) {
        const Detection found = detect_board(grey, parse_board(text));
        EXPECT_FALSE(found.found()) << text;
        EXPECT_TRUE(found.ids.empty());
    }
    EXPECT_THROW(detect_board(GreyImage(), parse_board("circles:6x5:10")), std::invalid_argument);
}

TEST(DetectBoard, RefusesAChessboardWithMoreSquares) {
    std::mt19937 rng(2);
    const Scene scene = picture_of(parse_board("chessboard:9x6:10"), rng, 0.2);
    for (const char* wrong : {"chessboard:8x6:10", "chessboard:9x5:10", "chessboard:7x5:10"}) {
        const Detection found = detect_board(scene.image, parse_board(wrong));
        EXPECT_NE(found.refusal.find("wrong board"), std::string::npos) << found.refusal;
    }
}

TEST(DetectBoard, TellsAChessboardFromItselfTurnedWhereItCan) {
    EXPECT_FALSE(looks_same_turned(parse_board("chessboard:9x6:10")));
    EXPECT_TRUE(looks_same_turned(parse_board("chessboard:9x7:10")));
    EXPECT_TRUE(looks_same_turned(parse_board("circles:6x5:10")));
    EXPECT_FALSE(looks_same_turned(parse_board("acircles:4x11:10")));
    EXPECT_FALSE(looks_same_turned(parse_board("charuco:8x6:12:6:DICT_6X6_250")));
}

}  // namespace
}  // namespace stria

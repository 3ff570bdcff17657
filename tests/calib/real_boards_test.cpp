// Our camera beside OpenCV's, on the same corners of real photographs.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <opencv2/calib3d.hpp>

#include "calib/camera_calibration.h"
#include "calib/detect_board.h"
#include "host/core/p_values.h"
#include "host/io/image_io.h"

namespace stria {
namespace {

struct Photographs {
    std::vector<CameraView> views;
    std::vector<std::string> refused;
    int width = 0, height = 0;
};

Photographs detect_all(const std::string& folder, const std::string& prefix, int first, int last,
                       const std::string& format, const Board& board) {
    Photographs set;
    for (int i = first; i <= last; ++i) {
        char name[64];
        std::snprintf(name, sizeof name, format.c_str(), i);
        const GreyImage image = read_grey_image(folder + "/" + prefix + name);
        set.width = image.width;
        set.height = image.height;
        const Detection found = detect_board(image, board);
        if (found.found())
            set.views.push_back({prefix + name, found.ids, found.pixels, {}});
        else
            set.refused.push_back(prefix + name + ": " + found.refusal);
    }
    return set;
}

double opencv_rms_px(const Photographs& set, const Board& board, double& fx) {
    const auto points = board_points(board);
    std::vector<std::vector<cv::Point3f>> on_board;
    std::vector<std::vector<cv::Point2f>> in_image;
    for (const CameraView& view : set.views) {
        on_board.emplace_back();
        in_image.emplace_back();
        for (std::size_t i = 0; i < view.ids.size(); ++i) {
            const auto& p = points[static_cast<std::size_t>(view.ids[i])];
            on_board.back().emplace_back(float(p.x()), float(p.y()), 0.0F);
            in_image.back().emplace_back(float(view.pixels[i].x()), float(view.pixels[i].y()));
        }
    }
    cv::Mat k, d;
    std::vector<cv::Mat> r, t;
    const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 300, 1e-12);
    const double rms = cv::calibrateCamera(on_board, in_image, cv::Size(set.width, set.height), k,
                                           d, r, t, 0, until);
    fx = k.at<double>(0, 0);
    return rms;
}

class RealBoards : public testing::Test {
  protected:
    void SetUp() override {
        const char* data = std::getenv("STRIA_TEST_DATA");
        if (!data) GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
        data_ = data;
    }

    /// With every corner kept, the minimum of the same function on the same corners cannot be above
    /// OpenCV's; 1e-6 px is for its stopping.
    void compare(const Photographs& set, const Board& board) {
        for (const auto& why : set.refused) std::cout << "refused " << why << '\n';
        double opencv_fx = 0;
        const double opencv = opencv_rms_px(set, board, opencv_fx);
        const auto all =
            calibrate_camera(set.views, board, set.width, set.height, {.reject_outliers = false});
        const auto found = calibrate_camera(set.views, board, set.width, set.height);
        std::cout << to_string(board) << ": rms " << all.rms_px << " px on all corners, OpenCV "
                  << opencv << " px; fx " << all.camera.fx << ", OpenCV " << opencv_fx
                  << "; with rejection " << found.rms_px << " px, " << found.views_used
                  << " views, fx " << found.camera.fx << " +- " << std::sqrt(found.covariance(0, 0))
                  << '\n';
        EXPECT_TRUE(all.converged);
        EXPECT_LE(all.rms_px, opencv + 1e-6);
        EXPECT_LE(found.rms_px, opencv + 1e-6);
        for (const auto& view : found.views) {
            if (!view.rejected.empty()) std::cout << view.name << ": " << view.rejected << '\n';
            for (int id : view.ids_rejected)
                std::cout << view.name << ": corner " << id << " left out\n";
        }
    }
    /// The views of even and of odd place, each calibrated alone: do they differ by more than their
    /// covariances say?
    void compare_halves(const Photographs& set, const Board& board) {
        for (bool warp : {false, true}) {
            CameraCalibration halves[2];
            for (int h = 0; h < 2; ++h) {
                std::vector<CameraView> views;
                for (std::size_t i = static_cast<std::size_t>(h); i < set.views.size(); i += 2)
                    views.push_back(set.views[i]);
                halves[h] =
                    calibrate_camera(views, board, set.width, set.height, {.board_warp = warp});
                const CornerNoise& noise = halves[h].noise;
                std::cout << to_string(board) << (warp ? " with warp" : "") << ", half " << h
                          << ": " << views.size() << " views, fx " << halves[h].camera.fx << " +- "
                          << std::sqrt(halves[h].covariance(0, 0)) << ", corners err by "
                          << noise.sigma_px << " px, " << noise.shared
                          << " of the variance shared over " << noise.reach_pitches << " pitches\n";
            }
            const Eigen::VectorXd difference =
                entries(halves[0].camera) - entries(halves[1].camera);
            const Eigen::MatrixXd covariance = halves[0].covariance + halves[1].covariance;
            const double chi_square = difference.dot(covariance.ldlt().solve(difference));
            const double p = chi_square_tail(chi_square, static_cast<double>(difference.size()));
            std::cout << "chi-square " << chi_square << " of " << difference.size() << ", p " << p
                      << '\n';
            EXPECT_GT(p, 0.01);
        }
    }

    static Eigen::VectorXd entries(const CameraModel& camera) {
        Eigen::VectorXd all(9);
        all << camera.fx, camera.fy, camera.cx, camera.cy, camera.distortion[0],
            camera.distortion[1], camera.distortion[2], camera.distortion[3], camera.distortion[4];
        return all;
    }
    std::string data_;
};

TEST_F(RealBoards, ChessboardIsNotWorseThanOpenCvAndItsHalvesAgree) {
    const Board board = parse_board("chessboard:9x6:23.9");
    const auto set = detect_all(data_ + "/stereo_chessboard_9x6", "left", 1, 15, "%02d.jpg", board);
    EXPECT_GE(set.views.size(), 14u);
    compare(set, board);
    compare_halves(set, board);
}

TEST_F(RealBoards, CharucoIsNotWorseThanOpenCvAndItsHalvesAgree) {
    const Board board = parse_board("charuco:7x5:20:10:DICT_6X6_250");
    const auto set = detect_all(data_ + "/charuco_5x7", "", 1, 7, "%d.jpg", board);
    EXPECT_EQ(set.views.size(), 7u);
    compare(set, board);
    compare_halves(set, board);
}

TEST_F(RealBoards, CircleGridIsNotWorseThanOpenCvAndItsHalvesAgree) {
    const Board board = parse_board("circles:7x7:37.5");
    const auto set = detect_all(data_ + "/laser_plane_circlegrid", "calib", 0, 11, "%d.jpg", board);
    EXPECT_EQ(set.views.size(), 12u);
    compare(set, board);
    compare_halves(set, board);
}

TEST_F(RealBoards, WhatIsFoundDoesNotDependOnWhatWasLookedAtBefore) {
    const GreyImage hard = read_grey_image(data_ + "/stereo_chessboard_9x6/left10.jpg");
    const Board board = parse_board("chessboard:9x6:23.9");
    const std::string first = detect_board(hard, board).refusal;
    ASSERT_FALSE(first.empty());
    for (unsigned state = 1; state <= 3; ++state) {
        cv::theRNG() = cv::RNG(state * 7919);
        EXPECT_EQ(detect_board(hard, board).refusal, first) << state;
        EXPECT_EQ(cv::theRNG().state, cv::RNG(state * 7919).state) << "the caller's generator";
    }
}

TEST_F(RealBoards, WrongOrMissingBoardsAreRefusedByName) {
    const std::string charuco = data_ + "/charuco_5x7/";
    const GreyImage seven_by_five = read_grey_image(charuco + "1.jpg");
    const auto turned = detect_board(seven_by_five, parse_board("charuco:5x7:20:10:DICT_6X6_250"));
    EXPECT_NE(turned.refusal.find("wrong board"), std::string::npos) << turned.refusal;
    const auto other = detect_board(seven_by_five, parse_board("charuco:7x5:20:10:DICT_4X4_50"));
    EXPECT_FALSE(other.found());
    const auto marker = detect_board(read_grey_image(charuco + "no_board_single_marker.jpg"),
                                     parse_board("charuco:7x5:20:10:DICT_6X6_250"));
    EXPECT_FALSE(marker.found());
    const GreyImage nine_by_six = read_grey_image(data_ + "/stereo_chessboard_9x6/left02.jpg");
    for (const char* wrong : {"chessboard:8x6:20", "chessboard:8x5:20", "chessboard:10x7:20"}) {
        const auto found = detect_board(nine_by_six, parse_board(wrong));
        EXPECT_FALSE(found.found()) << wrong;
    }
}

}  // namespace
}  // namespace stria

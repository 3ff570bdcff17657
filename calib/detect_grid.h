#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "calib/detect_board.h"

/// For calib's own .cpp files only: it shows OpenCV.
namespace stria {

Detection detect_chessboard(const cv::Mat& image, const Board& board);
Detection detect_circles(const cv::Mat& image, const Board& board);

/// Moves saddle corners to where the gradients around them point past them (Foerstner's condition,
/// by cv::cornerSubPix); half_px[i] is half the window of corner i. Corners that run away by more
/// than their window keep their old place.
void refine_corners(const cv::Mat& image, std::vector<cv::Point2f>& corners,
                    const std::vector<double>& half_px);

}  // namespace stria

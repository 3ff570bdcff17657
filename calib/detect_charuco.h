#pragma once
#include <opencv2/core.hpp>

#include "calib/detect_board.h"

/// For calib's own .cpp files only: it shows OpenCV.
namespace stria {

Detection detect_charuco(const cv::Mat& image, const Board& board);

}  // namespace stria

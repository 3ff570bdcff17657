#pragma once
#include <opencv2/aruco/charuco.hpp>

#include "host/core/board.h"

/// For calib's own .cpp files only: it shows OpenCV.
namespace stria {

/// OpenCV's predefined dictionary of that name. Throws stria::Error naming the known ones.
cv::Ptr<cv::aruco::Dictionary> aruco_dictionary(const std::string& name);

/// OpenCV's board, lengths in mm. Throws stria::Error if the dictionary has too few markers.
cv::Ptr<cv::aruco::CharucoBoard> charuco_board(const Board& board);

}  // namespace stria

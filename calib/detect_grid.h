#pragma once
#include <opencv2/core.hpp>
#include <vector>

#include "calib/detect_board.h"

/// For calib's own .cpp files only: it shows OpenCV.
namespace stria {

Detection detect_chessboard(const cv::Mat& image, const Board& board);
Detection detect_circles(const cv::Mat& image, const Board& board);

/// Row by row corners of a grid that may have been found mirrored: swapped so that x of the board,
/// y of the board and the viewing direction are right-handed.
void make_right_handed(std::vector<cv::Point2f>& corners, int columns, int rows);
/// All points of a board, by id.
Detection make_detection(const std::vector<cv::Point2f>& corners);
/// The detection, or the refusal that fault_of_view() gives it.
Detection without_faults(const cv::Mat& image, const Board& board, Detection found);

/// Moves saddle corners to where the gradients around them point past them (Foerstner's condition,
/// by cv::cornerSubPix); half_px[i] is half the window of corner i. Corners that run away by more
/// than their window keep their old place.
void refine_corners(const cv::Mat& image, std::vector<cv::Point2f>& corners,
                    const std::vector<double>& half_px);

}  // namespace stria

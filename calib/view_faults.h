#pragma once
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calib/detect_board.h"

/// What spoils a view of a board, named. For calib's own .cpp files only: it shows OpenCV.
namespace stria {

/// Standard deviation (px) of the sharpest edges in a picture: the median over its steepest places
/// of local contrast / (sqrt(2 pi) slope). Empty where nothing rises above the noise.
std::optional<double> edge_sigma_px(const cv::Mat& image);

/// Bounding box of the largest saturated spot if it covers at least 0.2 % of the picture.
std::optional<cv::Rect> saturated_spot(const cv::Mat& image);

/// Empty if a found board's points are good for measuring, else "too oblique: ..." (seen at more
/// than 75 deg) or "blur: ..." (edges wider than an eighth of the pitch, and 2.5 px).
std::string fault_of_view(const cv::Mat& image, const Board& board, const Detection& found);

using Finder = std::function<bool(const cv::Mat&)>;
/// "too oblique: ..." if the finder sees the board once the picture is stretched three times along
/// its rows, its columns or a diagonal; else empty. Works on a copy whose longer side is
/// `longest_px` at most.
std::string oblique_if_found_stretched(const cv::Mat& image, const Finder& find,
                                       double longest_px = 640);

/// "blur: ..." if even the sharpest edges of the picture are wider than 3 px and 0.4 % of its
/// longer side; else empty.
std::string blur_of_picture(const cv::Mat& image);

/// "glare: ..." if a saturated spot touches that part of the picture; else empty.
std::string glare_near(const cv::Mat& image, const cv::Rect& part);

/// The part of the picture that holds the points, grown by `margin_px` to every side.
cv::Rect part_around(const std::vector<cv::Point2f>& points, double margin_px);

}  // namespace stria

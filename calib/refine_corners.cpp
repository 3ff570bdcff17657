#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "calib/detect_grid.h"

namespace stria {

void refine_corners(const cv::Mat& image, std::vector<cv::Point2f>& corners,
                    const std::vector<double>& half_px) {
    const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 60, 1e-4);
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const int half = std::clamp(static_cast<int>(std::lround(half_px[i])), 2, 15);
        std::vector<cv::Point2f> one = {corners[i]};
        cv::cornerSubPix(image, one, cv::Size(half, half), cv::Size(-1, -1), until);
        if (cv::norm(one[0] - corners[i]) <= half) corners[i] = one[0];
    }
}

}  // namespace stria

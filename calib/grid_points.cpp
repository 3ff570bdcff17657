#include <algorithm>
#include <numeric>

#include "calib/detect_grid.h"
#include "calib/view_faults.h"

namespace stria {

void make_right_handed(std::vector<cv::Point2f>& corners, int columns, int rows) {
    const auto at = [&](int row, int column) {
        return corners[static_cast<std::size_t>(row * columns + column)];
    };
    const cv::Point2f x = at(0, columns - 1) - at(0, 0);
    const cv::Point2f y = at(rows - 1, 0) - at(0, 0);
    if (x.x * y.y - x.y * y.x > 0) return;
    for (int row = 0; row < rows; ++row)
        std::reverse(corners.begin() + row * columns, corners.begin() + (row + 1) * columns);
}

Detection make_detection(const std::vector<cv::Point2f>& corners) {
    Detection detection;
    detection.ids.resize(corners.size());
    std::iota(detection.ids.begin(), detection.ids.end(), 0);
    for (const cv::Point2f& corner : corners) detection.pixels.emplace_back(corner.x, corner.y);
    return detection;
}

Detection without_faults(const cv::Mat& image, const Board& board, Detection found) {
    std::string fault = fault_of_view(image, board, found);
    if (fault.empty()) return found;
    Detection none;
    none.refusal = std::move(fault);
    return none;
}

}  // namespace stria

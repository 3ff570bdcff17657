#include "calib/detect_charuco.h"

#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>

#include "calib/aruco_dictionary.h"
#include "calib/detect_grid.h"

namespace stria {
namespace {

constexpr std::size_t kLeastCorners = 6;

struct Markers {
    std::vector<int> ids;
    std::vector<std::vector<cv::Point2f>> corners;
};

/// Share of the markers whose corners one homography of the board explains, to a quarter of their
/// side.
double explained_share(const cv::aruco::CharucoBoard& board, const Markers& markers) {
    std::vector<cv::Point2f> on_board, in_image;
    double side_px = 0;
    for (std::size_t i = 0; i < markers.ids.size(); ++i) {
        const auto& points = board.objPoints[static_cast<std::size_t>(markers.ids[i])];
        for (std::size_t k = 0; k < 4; ++k) {
            on_board.emplace_back(points[k].x, points[k].y);
            in_image.push_back(markers.corners[i][k]);
        }
        side_px += cv::norm(markers.corners[i][0] - markers.corners[i][2]) / 1.4142;
    }
    side_px /= static_cast<double>(markers.ids.size());
    std::vector<std::uint8_t> inlier;
    const cv::Mat h = cv::findHomography(on_board, in_image, cv::RANSAC, 0.25 * side_px, inlier);
    if (h.empty()) return 0;
    return cv::sum(inlier)[0] / static_cast<double>(inlier.size());
}

/// Half windows that stay clear of the neighbouring corners and of the markers.
std::vector<double> window_sizes(const Board& board, const std::map<int, cv::Point2f>& corners) {
    const int columns = board.columns - 1;
    const double gap = 0.5 * (1 - board.marker_mm / board.pitch_mm);  // in squares
    std::vector<double> half;
    for (const auto& [id, corner] : corners) {
        double nearest = 1e9;
        for (int step : {1, -1, columns, -columns}) {
            if (std::abs(step) == 1 && (id + step) / columns != id / columns) continue;
            const auto other = corners.find(id + step);
            if (other != corners.end())
                nearest = std::min<double>(nearest, cv::norm(other->second - corner));
        }
        half.push_back(nearest > 1e8 ? 2 : std::min(0.35 * nearest, gap * nearest - 1.5));
    }
    return half;
}

Detection refused(const std::string& why) {
    Detection none;
    none.refusal = why;
    return none;
}

}  // namespace

Detection detect_charuco(const cv::Mat& image, const Board& board) {
    const auto charuco = charuco_board(board);
    const auto parameters = cv::aruco::DetectorParameters::create();
    Markers markers;
    std::vector<std::vector<cv::Point2f>> rejected;
    cv::aruco::detectMarkers(image, charuco->dictionary, markers.corners, markers.ids, parameters,
                             rejected);
    if (markers.ids.empty()) return refused("no marker of " + board.dictionary + " found");
    const int known = static_cast<int>(charuco->ids.size());
    const auto strangers =
        std::count_if(markers.ids.begin(), markers.ids.end(), [&](int id) { return id >= known; });
    if (2 * strangers >= static_cast<long>(markers.ids.size()))
        return refused("wrong board: " + std::to_string(strangers) + " of " +
                       std::to_string(markers.ids.size()) + " markers have ids above " +
                       std::to_string(known - 1));
    for (std::size_t i = markers.ids.size(); i-- > 0;)
        if (markers.ids[i] >= known) {
            markers.ids.erase(markers.ids.begin() + static_cast<long>(i));
            markers.corners.erase(markers.corners.begin() + static_cast<long>(i));
        }
    if (markers.ids.size() >= 2 && explained_share(*charuco, markers) < 0.7)
        return refused("wrong board: the markers are not where " + to_string(board) + " puts them");

    std::vector<cv::Point2f> found;
    std::vector<int> ids;
    cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, image, charuco, found, ids);
    if (ids.size() < kLeastCorners)
        return refused("too few corners: " + std::to_string(ids.size()) + " found, at least " +
                       std::to_string(kLeastCorners) + " needed");

    std::map<int, cv::Point2f> by_id;
    for (std::size_t i = 0; i < ids.size(); ++i) by_id[ids[i]] = found[i];
    std::vector<cv::Point2f> ordered;
    for (const auto& [id, corner] : by_id) ordered.push_back(corner);
    refine_corners(image, ordered, window_sizes(board, by_id));

    Detection detection;
    for (const auto& [id, corner] : by_id) detection.ids.push_back(id);
    for (const cv::Point2f& corner : ordered) detection.pixels.emplace_back(corner.x, corner.y);
    return detection;
}

}  // namespace stria

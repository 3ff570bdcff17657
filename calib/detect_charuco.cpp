#include "calib/detect_charuco.h"

#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>

#include "calib/aruco_dictionary.h"
#include "calib/charuco_markers.h"
#include "calib/detect_grid.h"
#include "calib/view_faults.h"

namespace stria {
namespace {

constexpr std::size_t kLeastCorners = 6;
constexpr double kMarkersPx = 1280;  // of a picture whose markers can be read

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

/// Corners of a charuco board in a picture, by id; at least 0 of them.
std::map<int, cv::Point2f> corners_between(const cv::Mat& image, const Markers& markers,
                                           const cv::Ptr<cv::aruco::CharucoBoard>& charuco) {
    std::vector<cv::Point2f> found;
    std::vector<int> ids;
    if (!markers.ids.empty())
        cv::aruco::interpolateCornersCharuco(markers.corners, markers.ids, image, charuco, found,
                                             ids);
    std::map<int, cv::Point2f> by_id;
    for (std::size_t i = 0; i < ids.size(); ++i) by_id[ids[i]] = found[i];
    return by_id;
}

/// Why markers of the right board give no corners, or why there are none.
std::string why_no_corners(const cv::Mat& image, const Board& board, const Markers& markers,
                           std::size_t corners) {
    const auto charuco = charuco_board(board);
    const auto find = [&](const cv::Mat& picture) {
        const Markers seen = with_ids_below(find_markers(picture, charuco->dictionary),
                                            static_cast<int>(charuco->ids.size()));
        return seen.ids.size() >= 2 && explained_share(*charuco, seen) >= 0.7 &&
               corners_between(picture, seen, charuco).size() >= kLeastCorners;
    };
    if (const std::string why = oblique_if_found_stretched(image, find, kMarkersPx); !why.empty())
        return why;
    if (const std::string why = blur_of_picture(image); !why.empty()) return why;
    if (markers.ids.empty()) return "not found: no marker of " + board.dictionary;
    std::vector<cv::Point2f> points;
    for (const auto& marker : markers.corners)
        points.insert(points.end(), marker.begin(), marker.end());
    const double side = cv::norm(markers.corners[0][0] - markers.corners[0][1]);
    const double board_px =
        side * std::max(board.columns, board.rows) * board.pitch_mm / board.marker_mm;
    if (const std::string why = glare_near(image, part_around(points, board_px)); !why.empty())
        return why;
    return "too few corners: " + std::to_string(corners) + " found, at least " +
           std::to_string(kLeastCorners) + " needed";
}

}  // namespace

Detection detect_charuco(const cv::Mat& image, const Board& board) {
    const auto charuco = charuco_board(board);
    const Markers all = find_markers(image, charuco->dictionary);
    if (const std::string why = wrong_charuco(image, board, all); !why.empty()) return refused(why);
    const Markers markers = with_ids_below(all, static_cast<int>(charuco->ids.size()));
    const auto by_id = corners_between(image, markers, charuco);
    if (by_id.size() < kLeastCorners)
        return refused(why_no_corners(image, board, markers, by_id.size()));

    std::vector<cv::Point2f> ordered;
    for (const auto& [id, corner] : by_id) ordered.push_back(corner);
    refine_corners(image, ordered, window_sizes(board, by_id));

    Detection detection;
    for (const auto& [id, corner] : by_id) detection.ids.push_back(id);
    for (const cv::Point2f& corner : ordered) detection.pixels.emplace_back(corner.x, corner.y);
    return without_faults(image, board, std::move(detection));
}

}  // namespace stria

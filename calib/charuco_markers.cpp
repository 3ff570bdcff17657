#include "calib/charuco_markers.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "calib/aruco_dictionary.h"

namespace stria {
namespace {

constexpr double kFits = 0.7, kFitsWell = 0.85;  // share of the markers that a board explains
constexpr double kClearlyMore = 1.5;             // markers
constexpr std::size_t kLeastMarkers = 4;         // that name another board
constexpr int kMostColumns = 20;

/// The largest dictionary of each family; its smaller ones are its first markers.
const char* const kFamilies[] = {"DICT_4X4_1000", "DICT_5X5_1000", "DICT_6X6_1000", "DICT_7X7_1000",
                                 "DICT_ARUCO_ORIGINAL"};

std::string family_of(const std::string& dictionary) {
    return dictionary.substr(0, dictionary.rfind('_'));
}

/// The smallest dictionary of a family that holds that id.
std::string smallest_with(const std::string& family, int id) {
    if (family_of(family) == "DICT_ARUCO") return family;
    for (const int size : {50, 100, 250})
        if (id < size) return family_of(family) + "_" + std::to_string(size);
    return family;
}

int largest_id(const Markers& markers) {
    return *std::max_element(markers.ids.begin(), markers.ids.end());
}

/// The board with that many columns and at least that many rows that holds every marker.
Board holding(Board board, int columns, const Markers& markers) {
    board.columns = columns;
    while (board.columns * board.rows / 2 <= largest_id(markers)) ++board.rows;
    return board;
}

/// How many markers the board explains: those with its ids, whose corners one homography of it
/// puts where they are, to a quarter of their side.
double explained(const Board& board, const Markers& all) {
    const Markers markers = with_ids_below(all, board.columns * board.rows / 2);
    if (markers.ids.empty()) return 0;
    return explained_share(*charuco_board(board), markers) *
           static_cast<double>(markers.ids.size());
}

/// The board that explains nearly all markers, more than the expected one does: the swapped one
/// before others.
std::optional<Board> explaining(const Board& expected, const Markers& markers) {
    if (markers.ids.size() < kLeastMarkers) return std::nullopt;
    const int of_dictionary = aruco_dictionary(expected.dictionary)->bytesList.rows;
    Board swapped = expected;
    std::swap(swapped.columns, swapped.rows);
    std::vector<Board> candidates = {swapped};
    for (int columns = 3; columns <= kMostColumns; ++columns) {
        Board other = expected;
        other.rows = 2;
        candidates.push_back(holding(other, columns, markers));
    }
    std::optional<Board> best;
    double most = std::max(kFitsWell * static_cast<double>(markers.ids.size()),
                           explained(expected, markers) + kClearlyMore);
    for (const Board& candidate : candidates) {
        const int held = candidate.columns * candidate.rows / 2;
        if (held <= largest_id(markers) || held > of_dictionary) continue;
        const double count = explained(candidate, markers);
        if (count < most) continue;
        most = count + kClearlyMore;  // or the earlier candidate stays
        best = candidate;
    }
    return best;
}

std::string squares(const Board& board) {
    return std::to_string(board.columns) + " x " + std::to_string(board.rows) + " squares";
}

std::string other_layout(const Board& shown, const Board& expected) {
    if (shown.columns == expected.rows && shown.rows == expected.columns)
        return "wrong board: the picture shows " + squares(shown) + ", expected " +
               squares(expected) + ": columns and rows are swapped";
    return "wrong board: the picture shows a board of " + std::to_string(shown.columns) +
           " columns and at least " + std::to_string(shown.rows) + " rows of squares, expected " +
           squares(expected);
}

/// The board whose markers are of another dictionary, whatever its layout.
std::string other_dictionary(const cv::Mat& image, const Board& board) {
    std::string best;
    std::size_t most = kLeastMarkers - 1;
    for (const char* family : kFamilies) {
        if (family_of(family) == family_of(board.dictionary)) continue;
        const Markers markers = find_markers(image, aruco_dictionary(family));
        if (markers.ids.size() <= most) continue;
        Board other = board;
        other.dictionary = family;
        const double enough = kFitsWell * static_cast<double>(markers.ids.size());
        if (explained(other, markers) < enough && !explaining(other, markers)) continue;
        most = markers.ids.size();
        best = smallest_with(family, largest_id(markers));
    }
    if (best.empty()) return "";
    return "wrong board: its markers are of " + best + ", expected " + board.dictionary;
}

}  // namespace

Markers find_markers(const cv::Mat& image, const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
    Markers markers;
    std::vector<std::vector<cv::Point2f>> rejected;
    cv::aruco::detectMarkers(image, dictionary, markers.corners, markers.ids,
                             cv::aruco::DetectorParameters::create(), rejected);
    return markers;
}

Markers with_ids_below(const Markers& markers, int count) {
    Markers kept;
    for (std::size_t i = 0; i < markers.ids.size(); ++i) {
        if (markers.ids[i] >= count) continue;
        kept.ids.push_back(markers.ids[i]);
        kept.corners.push_back(markers.corners[i]);
    }
    return kept;
}

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

std::string wrong_charuco(const cv::Mat& image, const Board& board, const Markers& markers) {
    const int known = board.columns * board.rows / 2;
    const std::size_t ours = with_ids_below(markers, known).ids.size();
    const std::size_t all = markers.ids.size(), strangers = all - ours;
    if (all < kLeastMarkers)
        if (std::string other = other_dictionary(image, board); !other.empty()) return other;
    if (all < 2) return "";
    const bool fits = explained(board, markers) >= kFits * static_cast<double>(ours);
    if (fits && strangers < 2 && ours >= 2) return "";
    if (const auto shown = explaining(board, markers)) return other_layout(*shown, board);
    if (2 * strangers >= all)
        return "wrong board: " + std::to_string(strangers) + " of " + std::to_string(all) +
               " markers have ids above " + std::to_string(known - 1);
    if (!fits && ours >= 2)
        return "wrong board: the markers are not where " + to_string(board) + " puts them";
    return "";
}

}  // namespace stria

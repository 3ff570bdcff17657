#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <optional>

#include "calib/detect_grid.h"
#include "calib/view_faults.h"

namespace stria {
namespace {

using Centres = std::vector<cv::Point2f>;

constexpr double kSomeDiscs = 0.3;  // of the board's: it is there, and partly hidden

cv::Ptr<cv::FeatureDetector> blob_detector(const cv::Mat& image, const Board& board, bool wide) {
    cv::SimpleBlobDetector::Params params;
    if (wide) {
        params.minArea = 12;
        params.maxArea =
            static_cast<float>(image.total()) / static_cast<float>(board.columns * board.rows);
        params.minDistBetweenBlobs = 5;
    }
    return cv::SimpleBlobDetector::create(params);
}

bool find_grid(const cv::Mat& image, const Board& board, Centres& centres) {
    const cv::Size size(board.columns, board.rows);
    const int kind = board.kind == BoardKind::acircles ? cv::CALIB_CB_ASYMMETRIC_GRID
                                                       : cv::CALIB_CB_SYMMETRIC_GRID;
    for (const bool wide : {false, true})
        for (const int extra : {0, int{cv::CALIB_CB_CLUSTERING}})
            if (cv::findCirclesGrid(image, size, centres, kind + extra,
                                    blob_detector(image, board, wide)))
                return true;
    return false;
}

Centres blobs(const cv::Mat& image, const Board& board) {
    std::vector<cv::KeyPoint> found;
    blob_detector(image, board, true)->detect(image, found);
    Centres centres;
    for (const cv::KeyPoint& blob : found) centres.push_back(blob.pt);
    return centres;
}

std::string grid_of(const Board& board) {
    return std::string(board.kind == BoardKind::acircles ? "an asymmetric" : "a symmetric") +
           " grid of " + std::to_string(board.columns) + " x " + std::to_string(board.rows) +
           " circles";
}

/// A symmetric grid's columns are named where the expected board has its own.
Board named_as(Board shown, const Board& expected) {
    if (shown.kind == BoardKind::circles &&
        (shown.columns < shown.rows) != (expected.columns < expected.rows))
        std::swap(shown.columns, shown.rows);
    return shown;
}

bool may_be_part(const Board& shown, const Board& expected) {
    return shown.kind == expected.kind && shown.columns <= expected.columns &&
           shown.rows <= expected.rows;
}

std::string other_grid(const Board& shown, const Board& expected) {
    if (may_be_part(shown, expected))
        return "too few corners: the picture shows " + grid_of(shown) + ", expected " +
               grid_of(expected) +
               ": is part of the board covered, or outside the picture, or is it a smaller one?";
    return "wrong board: the picture shows " + grid_of(shown) + ", expected " + grid_of(expected) +
           (shown.columns == expected.rows && shown.rows == expected.columns
                ? ": columns and rows are swapped"
                : "");
}

/// Board points one step beyond a side of the grid.
std::vector<std::vector<cv::Point2f>> beyond(const Board& board) {
    Board more = board;  // one column and two rows more all round, to keep the parity of rows
    more.columns += 2;
    more.rows += 4;
    const double dx = (board.kind == BoardKind::acircles ? 2 : 1) * board.pitch_mm;
    std::vector<std::vector<cv::Point2f>> sides(4);
    const auto points = board_points(more);
    for (int r = 0; r < more.rows; ++r)
        for (int c = 0; c < more.columns; ++c) {
            const Eigen::Vector3d& p = points[static_cast<std::size_t>(r * more.columns + c)];
            const cv::Point2f at(static_cast<float>(p.x() - dx),
                                 static_cast<float>(p.y() - 2 * board.pitch_mm));
            const bool row_in = r >= 2 && r < more.rows - 2, in = c >= 1 && c < more.columns - 1;
            if (row_in && c == 0) sides[0].push_back(at);
            if (row_in && c == more.columns - 1) sides[1].push_back(at);
            if (in && r == 1) sides[2].push_back(at);
            if (in && r == more.rows - 2) sides[3].push_back(at);
        }
    return sides;
}

std::vector<cv::Point2f> flat_points(const Board& board) {
    std::vector<cv::Point2f> points;
    for (const Eigen::Vector3d& p : board_points(board))
        points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    return points;
}

/// Homography from the board to the picture; empty if there is none.
cv::Mat picture_from_board(const Board& board, const Centres& centres) {
    return cv::findHomography(flat_points(board), centres);
}

/// True if the discs lie as a flat board of that layout has them, to a fifth of their distance: a
/// search for rows and columns finds some in other layouts too.
bool is_flat_grid(const Board& board, const Centres& centres) {
    const cv::Mat h = picture_from_board(board, centres);
    if (h.empty()) return false;
    Centres expected;
    cv::perspectiveTransform(flat_points(board), expected, h);
    for (std::size_t i = 0; i + 1 < centres.size(); ++i) {
        const bool last = (i + 1) % static_cast<std::size_t>(board.columns) == 0;
        const double step = last ? 1e9 : cv::norm(centres[i + 1] - centres[i]);
        if (cv::norm(expected[i] - centres[i]) > 0.2 * step) return false;
    }
    return true;
}

/// True if more discs stand in line beyond one of the grid's sides.
bool goes_on(const cv::Mat& image, const Board& board, const Centres& centres) {
    const cv::Mat h = picture_from_board(board, centres);
    if (h.empty()) return false;
    const Centres discs = blobs(image, board);
    const double near = 0.2 * cv::norm(centres[1] - centres[0]);
    for (const auto& side : beyond(board)) {
        Centres expected;
        cv::perspectiveTransform(side, expected, h);
        const auto there = std::count_if(expected.begin(), expected.end(), [&](const auto& at) {
            return std::any_of(discs.begin(), discs.end(),
                               [&](const auto& disc) { return cv::norm(disc - at) < near; });
        });
        if (static_cast<double>(there) > 0.7 * static_cast<double>(side.size())) return true;
    }
    return false;
}

/// Another grid that the picture shows whole; empty if there is none: of either kind, the same
/// number swapped first, then those with as many circles as there are discs.
std::optional<Board> other_board(const cv::Mat& image, const Board& board, std::size_t discs) {
    std::vector<Board> candidates;
    for (const BoardKind kind :
         {board.kind, board.kind == BoardKind::circles ? BoardKind::acircles : BoardKind::circles})
        for (int columns = 3; columns <= 20; ++columns) {
            const int rows = static_cast<int>(discs) / columns;
            if (rows < 3 || static_cast<std::size_t>(rows * columns) != discs) continue;
            Board other = board;
            other.kind = kind;
            other.columns = columns;
            other.rows = rows;
            candidates.push_back(other);
        }
    for (const Board& other : candidates) {
        if (other.kind == board.kind && other.columns == board.columns && other.rows == board.rows)
            continue;
        Centres centres;
        if (find_grid(image, other, centres) && is_flat_grid(other, centres) &&
            !goes_on(image, other, centres))
            return other;
    }
    return std::nullopt;
}

std::string why_no_circles(const cv::Mat& image, const Board& board) {
    const Centres discs = blobs(image, board);
    if (const auto other = other_board(image, board, discs.size()))
        return other_grid(named_as(*other, board), board);
    const auto find = [&](const cv::Mat& picture) {
        Centres centres;
        return find_grid(picture, board, centres);
    };
    if (const std::string why = oblique_if_found_stretched(image, find); !why.empty()) return why;
    if (const std::string why = blur_of_picture(image); !why.empty()) return why;
    const int all = board.columns * board.rows;
    if (static_cast<double>(discs.size()) >= kSomeDiscs * all) {
        const std::string glare = glare_near(image, part_around(discs, 0));
        if (!glare.empty()) return glare;
        return "too few corners: " + std::to_string(discs.size()) + " discs are seen, but not " +
               grid_of(board) + ": is part of the board covered, or outside the picture?";
    }
    return "not found: there is not " + grid_of(board);
}

}  // namespace

Detection detect_circles(const cv::Mat& image, const Board& board) {
    Centres centres;
    Detection none;
    if (!find_grid(image, board, centres)) {
        none.refusal = why_no_circles(image, board);
        return none;
    }
    if (goes_on(image, board, centres)) {
        none.refusal = "wrong board: the pattern goes on beyond " + grid_of(board);
        return none;
    }
    if (board.kind == BoardKind::circles) make_right_handed(centres, board.columns, board.rows);
    return without_faults(image, board, make_detection(centres));
}

}  // namespace stria

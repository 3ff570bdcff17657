#include "calib/detect_grid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace stria {
namespace {

using Corners = std::vector<cv::Point2f>;

/// Row by row corners of a grid that may have been found mirrored: swapped so that x of the board,
/// y of the board and the viewing direction are right-handed.
void make_right_handed(Corners& corners, int columns, int rows) {
    const auto at = [&](int row, int column) {
        return corners[static_cast<std::size_t>(row * columns + column)];
    };
    const cv::Point2f x = at(0, columns - 1) - at(0, 0);
    const cv::Point2f y = at(rows - 1, 0) - at(0, 0);
    if (x.x * y.y - x.y * y.x > 0) return;
    for (int row = 0; row < rows; ++row)
        std::reverse(corners.begin() + row * columns, corners.begin() + (row + 1) * columns);
}

double grey_at(const cv::Mat& image, double x, double y) {
    const int column = static_cast<int>(std::lround(x)), row = static_cast<int>(std::lround(y));
    if (column < 0 || row < 0 || column >= image.cols || row >= image.rows) return -1;
    return image.at<std::uint8_t>(row, column);
}

/// Samples a chessboard in units of squares, through the homography of the nearest 2 x 2 corners.
class SquareSampler {
  public:
    SquareSampler(const cv::Mat& image, const Corners& corners, int columns, int rows)
        : image_(image), corners_(corners), columns_(columns), rows_(rows) {}

    /// Grey value at board point (x, y) squares; -1 outside the image.
    double operator()(double x, double y) const {
        const int c = std::clamp(static_cast<int>(std::floor(x)), 0, columns_ - 2);
        const int r = std::clamp(static_cast<int>(std::floor(y)), 0, rows_ - 2);
        const Corners from = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        const Corners to = {at(r, c), at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)};
        const cv::Matx33d h = cv::getPerspectiveTransform(from, to);
        const cv::Vec3d p = h * cv::Vec3d(x - c, y - r, 1);
        return grey_at(image_, p[0] / p[2], p[1] / p[2]);
    }

  private:
    const cv::Point2f& at(int row, int column) const {
        return corners_[static_cast<std::size_t>(row * columns_ + column)];
    }
    const cv::Mat& image_;
    const Corners& corners_;
    int columns_, rows_;
};

/// Mean of the squares that should be white minus that of those that should be black.
double contrast(const cv::Mat& image, const Corners& corners, int columns, int rows) {
    const SquareSampler grey(image, corners, columns, rows);
    double sum[2] = {0, 0};
    int count[2] = {0, 0};
    for (int r = 0; r + 1 < rows; ++r)
        for (int c = 0; c + 1 < columns; ++c) {
            // The square right below corner (0, 0) has the colour of the one above it: black.
            const int white = (r + c) % 2;
            sum[white] += grey(c + 0.5, r + 0.5);
            ++count[white];
        }
    if (count[0] == 0 || count[1] == 0) return 0;
    return sum[1] / count[1] - sum[0] / count[0];
}

/// True if the pattern goes on past one of its sides: one square beyond the outermost corners there
/// is still black against black and white against white, across the corner.
bool goes_on(const cv::Mat& image, const Corners& corners, int columns, int rows, double step) {
    const SquareSampler grey(image, corners, columns, rows);
    const auto is_saddle = [&](double x, double y) {
        const double a = grey(x - 0.25, y - 0.25), b = grey(x + 0.25, y - 0.25);
        const double c = grey(x + 0.25, y + 0.25), d = grey(x - 0.25, y + 0.25);
        if (std::min({a, b, c, d}) < 0) return false;
        const double least = 0.4 * step;
        return (std::min(a, c) - std::max(b, d) > least) ||
               (std::min(b, d) - std::max(a, c) > least);
    };
    const auto side = [&](int count, auto&& x_of, auto&& y_of) {
        int saddles = 0;
        for (int i = 0; i < count; ++i) saddles += is_saddle(x_of(i), y_of(i));
        return saddles > 0.7 * count;
    };
    const auto same = [](int i) { return static_cast<double>(i); };
    const auto fixed = [](double value) { return [value](int) { return value; }; };
    return side(columns, same, fixed(-1)) || side(columns, same, fixed(rows)) ||
           side(rows, fixed(-1), same) || side(rows, fixed(columns), same);
}

std::vector<double> window_sizes(const Corners& corners, int columns, int rows) {
    std::vector<double> half(corners.size());
    for (int r = 0; r < rows; ++r)
        for (int c = 0; c < columns; ++c) {
            const auto i = static_cast<std::size_t>(r * columns + c);
            double nearest = 1e9;
            for (const auto& [dr, dc] : {std::pair{0, 1}, {0, -1}, {1, 0}, {-1, 0}}) {
                if (r + dr < 0 || r + dr >= rows || c + dc < 0 || c + dc >= columns) continue;
                const auto j = static_cast<std::size_t>((r + dr) * columns + c + dc);
                nearest = std::min<double>(nearest, cv::norm(corners[i] - corners[j]));
            }
            half[i] = 0.35 * nearest;
        }
    return half;
}

Detection make_detection(const Corners& corners) {
    Detection detection;
    detection.ids.resize(corners.size());
    std::iota(detection.ids.begin(), detection.ids.end(), 0);
    for (const cv::Point2f& corner : corners) detection.pixels.emplace_back(corner.x, corner.y);
    return detection;
}

/// The sector-based detector first: fast, found or not. The classic one takes seconds on large
/// images that hold no such board, so it sees a smaller picture; refinement follows on the full
/// one.
bool find_chessboard(const cv::Mat& image, cv::Size size, Corners& corners) {
    for (int extra : {int{cv::CALIB_CB_EXHAUSTIVE}, 0})
        if (cv::findChessboardCornersSB(image, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE + extra))
            return true;
    const double shrink = std::min(1.0, 700.0 / std::max(image.cols, image.rows));
    cv::Mat small = image;
    if (shrink < 1) cv::resize(image, small, cv::Size(), shrink, shrink, cv::INTER_AREA);
    if (!cv::findChessboardCorners(
            small, size, corners,
            cv::CALIB_CB_ADAPTIVE_THRESH + cv::CALIB_CB_NORMALIZE_IMAGE + cv::CALIB_CB_FAST_CHECK))
        return false;
    for (cv::Point2f& corner : corners) {
        corner.x = static_cast<float>((corner.x + 0.5) / shrink - 0.5);
        corner.y = static_cast<float>((corner.y + 0.5) / shrink - 0.5);
    }
    return true;
}

/// Size of a chessboard in the picture that has more corners than `size`; empty if there is none.
cv::Size larger_chessboard(const cv::Mat& image, cv::Size size) {
    Corners corners;
    cv::Mat meta;
    const int flags = cv::CALIB_CB_NORMALIZE_IMAGE + cv::CALIB_CB_EXHAUSTIVE + cv::CALIB_CB_LARGER;
    if (!cv::findChessboardCornersSB(image, size, corners, flags, meta)) return {};
    return meta.cols * meta.rows > size.width * size.height ? meta.size() : cv::Size();
}

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

}  // namespace

Detection detect_chessboard(const cv::Mat& image, const Board& board) {
    const int columns = board.columns, rows = board.rows;
    Detection none;
    Corners corners;
    if (columns < 3 || rows < 3) {
        none.refusal = "a chessboard needs at least 3 x 3 inner corners to be found";
        return none;
    }
    if (const cv::Size more = larger_chessboard(image, cv::Size(columns, rows)); !more.empty()) {
        none.refusal = "wrong board: the picture shows " + std::to_string(more.width) + " x " +
                       std::to_string(more.height) + " inner corners, expected " +
                       std::to_string(columns) + " x " + std::to_string(rows);
        return none;
    }
    if (!find_chessboard(image, cv::Size(columns, rows), corners)) {
        none.refusal = "chessboard of " + std::to_string(columns) + " x " + std::to_string(rows) +
                       " inner corners not found";
        return none;
    }
    make_right_handed(corners, columns, rows);
    double step = contrast(image, corners, columns, rows);
    if (step < 0 && !looks_same_turned(board)) {
        std::reverse(corners.begin(), corners.end());  // half a turn
        step = contrast(image, corners, columns, rows);
    }
    if (goes_on(image, corners, columns, rows, std::abs(step))) {
        none.refusal = "wrong board: the pattern goes on beyond " + std::to_string(columns) +
                       " x " + std::to_string(rows) + " inner corners";
        return none;
    }
    refine_corners(image, corners, window_sizes(corners, columns, rows));
    return make_detection(corners);
}

Detection detect_circles(const cv::Mat& image, const Board& board) {
    const cv::Size size(board.columns, board.rows);
    const bool asymmetric = board.kind == BoardKind::acircles;
    const int kind = asymmetric ? cv::CALIB_CB_ASYMMETRIC_GRID : cv::CALIB_CB_SYMMETRIC_GRID;
    Corners centres;
    bool found = false;
    for (bool wide : {false, true})
        for (int extra : {0, int{cv::CALIB_CB_CLUSTERING}})
            if (!found)
                found = cv::findCirclesGrid(image, size, centres, kind + extra,
                                            blob_detector(image, board, wide));
    if (!found) {
        Detection none;
        none.refusal = "grid of " + std::to_string(size.width) + " x " +
                       std::to_string(size.height) + " circles not found";
        return none;
    }
    if (!asymmetric) make_right_handed(centres, size.width, size.height);
    return make_detection(centres);
}

}  // namespace stria

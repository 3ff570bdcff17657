#include "calib/detect_grid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/view_faults.h"

namespace stria {
namespace {

using Corners = std::vector<cv::Point2f>;

constexpr int kSmallest = 3;  // corners a side: less is no chessboard

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

/// Mean grey of the squares below right of corner (r, c), by the parity of r + c.
struct Levels {
    double even = 0, odd = 0;
};
Levels levels(const cv::Mat& image, const Corners& corners, int columns, int rows) {
    const SquareSampler grey(image, corners, columns, rows);
    double sum[2] = {0, 0};
    int count[2] = {0, 0};
    for (int r = 0; r + 1 < rows; ++r)
        for (int c = 0; c + 1 < columns; ++c) {
            sum[(r + c) % 2] += grey(c + 0.5, r + 0.5);
            ++count[(r + c) % 2];
        }
    if (count[0] == 0 || count[1] == 0) return {};
    return {sum[0] / count[0], sum[1] / count[1]};
}

/// Mean of the squares that should be white minus that of those that should be black: the square
/// right below corner (0, 0) has the colour of the one above it, black.
double contrast(const cv::Mat& image, const Corners& corners, int columns, int rows) {
    const Levels level = levels(image, corners, columns, rows);
    return level.odd - level.even;
}

/// Which lines of places on a grid are corners: black against black and white against white across
/// each place, in at least 70 % of them. Places are counted in squares from corner (0, 0).
class SaddleLines {
  public:
    SaddleLines(const cv::Mat& image, const Corners& corners, int columns, int rows, double step)
        : grey_(image, corners, columns, rows), columns_(columns), rows_(rows), step_(step) {}

    bool row(double y) const {
        int saddles = 0;
        for (int x = 0; x < columns_; ++x) saddles += is_saddle(x, y);
        return saddles > 0.7 * columns_;
    }
    bool column(double x) const {
        int saddles = 0;
        for (int y = 0; y < rows_; ++y) saddles += is_saddle(x, y);
        return saddles > 0.7 * rows_;
    }

  private:
    bool is_saddle(double x, double y) const {
        const double a = grey_(x - 0.25, y - 0.25), b = grey_(x + 0.25, y - 0.25);
        const double c = grey_(x + 0.25, y + 0.25), d = grey_(x - 0.25, y + 0.25);
        if (std::min({a, b, c, d}) < 0) return false;
        const double least = 0.4 * step_;
        return (std::min(a, c) - std::max(b, d) > least) ||
               (std::min(b, d) - std::max(a, c) > least);
    }

    SquareSampler grey_;
    int columns_, rows_;
    double step_;
};

/// True if the pattern goes on past one of its sides, one square beyond the outermost corners.
bool goes_on(const cv::Mat& image, const Corners& corners, int columns, int rows, double step) {
    const SaddleLines lines(image, corners, columns, rows, step);
    return lines.row(-1) || lines.row(rows) || lines.column(-1) || lines.column(columns);
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

/// True if the squares' means differ by more than twice what the grey values within them scatter:
/// in mere noise the detector finds small boards that do not.
bool stands_out(const cv::Mat& image, const Corners& corners, int columns, int rows) {
    constexpr int kSamples = 5;  // a square along each side, in its middle half
    const SquareSampler grey(image, corners, columns, rows);
    double within = 0, means[2] = {0, 0};
    int count = 0, of_parity[2] = {0, 0};
    for (int r = 0; r + 1 < rows; ++r)
        for (int c = 0; c + 1 < columns; ++c) {
            double sum = 0, squares = 0;
            for (int i = 0; i < kSamples * kSamples; ++i) {
                const double value = grey(c + 0.25 + 0.5 * (i % kSamples) / (kSamples - 1),
                                          r + 0.25 + 0.5 * (i / kSamples) / (kSamples - 1));
                sum += value;
                squares += value * value;
            }
            within += squares - sum * sum / (kSamples * kSamples);
            means[(r + c) % 2] += sum / (kSamples * kSamples);
            ++of_parity[(r + c) % 2];
            count += kSamples * kSamples - 1;
        }
    const double difference = means[1] / of_parity[1] - means[0] / of_parity[0];
    return std::abs(difference) > 2 * std::sqrt(std::max(0.0, within) / count);
}

/// The chessboard of at least that size in the picture, row by row; empty if there is none.
struct AnyChessboard {
    cv::Size size;
    Corners corners;
};
AnyChessboard chessboard_from(const cv::Mat& image, cv::Size least) {
    AnyChessboard found;
    cv::Mat meta;
    const int flags = cv::CALIB_CB_NORMALIZE_IMAGE + cv::CALIB_CB_EXHAUSTIVE + cv::CALIB_CB_LARGER;
    if (cv::findChessboardCornersSB(image, least, found.corners, flags, meta) &&
        stands_out(image, found.corners, meta.cols, meta.rows))
        found.size = meta.size();
    return found;
}

std::string inner_corners(cv::Size size) {
    return std::to_string(size.width) + " x " + std::to_string(size.height) + " inner corners";
}

/// A chessboard's corners may have been numbered along either side: the longer side is named where
/// the expected board has its own.
cv::Size named_as(cv::Size shown, cv::Size expected) {
    const auto [shorter, longer] = std::minmax(shown.width, shown.height);
    return expected.width >= expected.height ? cv::Size(longer, shorter)
                                             : cv::Size(shorter, longer);
}

std::string other_size(cv::Size shown, cv::Size expected) {
    return "wrong board: the picture shows " + inner_corners(named_as(shown, expected)) +
           ", expected " + inner_corners(expected);
}

bool same_sides(cv::Size a, cv::Size b) { return named_as(a, b) == b; }

/// True if the shown corners may be some of the expected board's.
bool may_be_part(cv::Size shown, cv::Size expected) {
    const cv::Size named = named_as(shown, expected);
    return named.width <= expected.width && named.height <= expected.height;
}

/// True if nothing of the board is hidden: beyond the outermost corners come squares that go on
/// alternating, and white paper beyond those, in the picture all round.
bool ends_in_paper(const cv::Mat& image, const AnyChessboard& board) {
    const int columns = board.size.width, rows = board.size.height;
    const SquareSampler grey(image, board.corners, columns, rows);
    Levels level = levels(image, board.corners, columns, rows);
    const bool swapped = level.even > level.odd;
    if (swapped) std::swap(level.even, level.odd);
    const double step = level.odd - level.even;
    int all = 0, squares = 0, paper = 0;
    const auto look = [&](int c, int r, double c_out, double r_out) {
        const bool white = ((r + c) % 2 != 0) != swapped;
        const double at = grey(c + 0.5, r + 0.5), beyond = grey(c_out, r_out);
        ++all;
        squares += at >= 0 && (at > level.even + 0.5 * step) == white;
        paper += beyond > level.even + 0.7 * step;
    };
    for (int c = 0; c + 1 < columns; ++c) {
        look(c, -1, c + 0.5, -1.3);
        look(c, rows - 1, c + 0.5, rows + 0.3);
    }
    for (int r = 0; r + 1 < rows; ++r) {
        look(-1, r, -1.3, r + 0.5);
        look(columns - 1, r, columns + 0.3, r + 0.5);
    }
    return squares >= 0.9 * all && paper >= 0.9 * all;
}

/// True if the outermost corners are corners. The detector sometimes takes the board's edge, where
/// its outer squares end in paper, for another line of them.
bool ends_in_corners(const cv::Mat& image, const AnyChessboard& board) {
    const int columns = board.size.width, rows = board.size.height;
    const double step = std::abs(contrast(image, board.corners, columns, rows));
    const SaddleLines lines(image, board.corners, columns, rows, step);
    return lines.row(0) && lines.row(rows - 1) && lines.column(0) && lines.column(columns - 1);
}

/// Why a chessboard was not found.
std::string why_no_chessboard(const cv::Mat& image, cv::Size size) {
    const AnyChessboard any = chessboard_from(image, cv::Size(kSmallest, kSmallest));
    const bool other = !any.size.empty() && !same_sides(any.size, size);
    std::string glare;
    if (other && may_be_part(any.size, size)) {
        const double missing =
            std::max(size.width, size.height) * cv::norm(any.corners[1] - any.corners[0]);
        glare = glare_near(image, part_around(any.corners, missing));
    }
    if (!glare.empty()) return glare;
    if (other && ends_in_paper(image, any)) return other_size(any.size, size);
    const auto find = [&](const cv::Mat& picture) {
        Corners corners;
        return cv::findChessboardCornersSB(picture, size, corners, cv::CALIB_CB_NORMALIZE_IMAGE);
    };
    if (const std::string why = oblique_if_found_stretched(image, find); !why.empty()) return why;
    if (other)
        return "too few corners: only " + inner_corners(named_as(any.size, size)) + " of " +
               inner_corners(size) +
               " are seen: is part of the board covered, or outside the picture?";
    if (const std::string why = blur_of_picture(image); !why.empty()) return why;
    return "not found: no chessboard of " + inner_corners(size);
}

}  // namespace

Detection detect_chessboard(const cv::Mat& image, const Board& board) {
    const int columns = board.columns, rows = board.rows;
    Detection none;
    Corners corners;
    const cv::Size size(columns, rows);
    if (columns < kSmallest || rows < kSmallest) {
        none.refusal = "a chessboard needs at least 3 x 3 inner corners to be found";
        return none;
    }
    const AnyChessboard larger = chessboard_from(image, size);
    if (larger.size.area() > size.area() && ends_in_corners(image, larger)) {
        none.refusal = other_size(larger.size, size);
        return none;
    }
    if (!find_chessboard(image, size, corners)) {
        none.refusal = why_no_chessboard(image, size);
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
    return without_faults(image, board, make_detection(corners));
}

}  // namespace stria

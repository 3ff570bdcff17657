#include "calib/view_faults.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "firmware/core/median.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

constexpr double kSqrtTwoPi = 2.5066282746;
constexpr double kSmoothPx = 1.0;          // before slopes are taken, against noise
constexpr int kReach = 31;                 // px of the window that local contrast is taken from
constexpr double kLeastContrast = 25;      // DN; noise and paper's texture stay below
constexpr double kSteepest = 0.002;        // share of the picture that counts as edges
constexpr double kFlattestRatio = 0.2588;  // cos 75 deg
constexpr double kWidestOfPitch = 0.125, kWidestPx = 2.5;
constexpr double kPictureWidestPx = 3, kPictureWidestShare = 0.004;
constexpr int kSaturated = 250;       // DN: JPEG leaves clipped areas a little below 255
constexpr double kSpotShare = 0.002;  // of the picture
constexpr double kStretch = 3;

/// Slope (DN per px) at every pixel of the smoothed picture.
cv::Mat slopes(const cv::Mat& smooth) {
    cv::Mat dx, dy, slope;
    cv::Sobel(smooth, dx, CV_32F, 1, 0, 3, 1.0 / 8);
    cv::Sobel(smooth, dy, CV_32F, 0, 1, 3, 1.0 / 8);
    cv::magnitude(dx, dy, slope);
    return slope;
}

/// Jacobian of the homography board -> picture at a board point: px per mm.
cv::Matx22d scale_at(const cv::Matx33d& h, double x, double y) {
    const cv::Vec3d p = h * cv::Vec3d(x, y, 1);
    cv::Matx22d jacobian;
    for (int r = 0; r < 2; ++r)
        for (int c = 0; c < 2; ++c) jacobian(r, c) = (h(r, c) - p[r] / p[2] * h(2, c)) / p[2];
    return jacobian;
}

/// Smaller and larger scale (px per mm) of the board at the middle of its points; empty if they do
/// not span a plane.
std::optional<cv::Vec2d> scales(const Board& board, const Detection& found) {
    const auto points = board_points(board);
    std::vector<cv::Point2d> on_board, in_image;
    cv::Point2d middle(0, 0);
    for (std::size_t i = 0; i < found.ids.size(); ++i) {
        const Eigen::Vector3d& p = points[static_cast<std::size_t>(found.ids[i])];
        on_board.emplace_back(p.x(), p.y());
        in_image.emplace_back(found.pixels[i].x(), found.pixels[i].y());
        middle += on_board.back() / static_cast<double>(found.ids.size());
    }
    if (on_board.size() < 4) return std::nullopt;
    const cv::Mat h = cv::findHomography(on_board, in_image);
    if (h.empty()) return std::nullopt;
    cv::Vec2d values;
    cv::SVD::compute(scale_at(h, middle.x, middle.y), values, cv::SVD::NO_UV);
    return cv::Vec2d(values[1], values[0]);
}

cv::Mat shrunk(const cv::Mat& image, double longest) {
    const double scale = std::min(1.0, longest / std::max(image.cols, image.rows));
    cv::Mat small = image;
    if (scale < 1) cv::resize(image, small, cv::Size(), scale, scale, cv::INTER_AREA);
    return small;
}

/// The picture turned by 45 deg on a canvas that holds it.
cv::Mat turned(const cv::Mat& image) {
    const cv::Point2f middle(0.5F * static_cast<float>(image.cols),
                             0.5F * static_cast<float>(image.rows));
    cv::Mat turn = cv::getRotationMatrix2D(middle, 45, 1);
    const int side = static_cast<int>(0.7072 * (image.cols + image.rows)) + 2;
    turn.at<double>(0, 2) += 0.5 * side - middle.x;
    turn.at<double>(1, 2) += 0.5 * side - middle.y;
    cv::Mat out;
    cv::warpAffine(image, out, turn, cv::Size(side, side), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return out;
}

}  // namespace

std::optional<double> edge_sigma_px(const cv::Mat& image) {
    cv::Mat smooth, low, high;
    cv::GaussianBlur(image, smooth, cv::Size(0, 0), kSmoothPx);
    const cv::Mat window = cv::getStructuringElement(cv::MORPH_RECT, cv::Size(kReach, kReach));
    cv::dilate(smooth, high, window);
    cv::erode(smooth, low, window);
    const cv::Mat slope = slopes(smooth);
    std::vector<std::pair<float, double>> edges;  // slope, sigma
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x) {
            const double contrast = high.at<std::uint8_t>(y, x) - low.at<std::uint8_t>(y, x);
            const float steep = slope.at<float>(y, x);
            if (contrast < kLeastContrast || !(steep > 0)) continue;
            edges.emplace_back(steep, contrast / (kSqrtTwoPi * static_cast<double>(steep)));
        }
    const auto count = static_cast<std::size_t>(kSteepest * static_cast<double>(image.total())) + 1;
    if (edges.size() < count) return std::nullopt;
    std::nth_element(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(count - 1),
                     edges.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<double> sigmas;
    for (std::size_t i = 0; i < count; ++i) sigmas.push_back(edges[i].second);
    const double blurred = median(std::move(sigmas));
    return std::sqrt(std::max(0.0, blurred * blurred - kSmoothPx * kSmoothPx));
}

std::optional<cv::Rect> saturated_spot(const cv::Mat& image) {
    cv::Mat labels, stats, centres;
    const int count =
        cv::connectedComponentsWithStats(image >= kSaturated, labels, stats, centres, 8);
    std::optional<cv::Rect> spot;
    int largest = static_cast<int>(kSpotShare * static_cast<double>(image.total()));
    for (int i = 1; i < count; ++i) {
        if (stats.at<int>(i, cv::CC_STAT_AREA) <= largest) continue;
        largest = stats.at<int>(i, cv::CC_STAT_AREA);
        spot = cv::Rect(stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                        stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT));
    }
    return spot;
}

std::string fault_of_view(const cv::Mat& image, const Board& board, const Detection& found) {
    const auto scale = scales(board, found);
    if (!scale) return "too few corners: they lie on one line";
    const double ratio = (*scale)[0] / (*scale)[1];
    if (ratio < kFlattestRatio)
        return "too oblique: the board is seen at " +
               short_number(std::acos(ratio) * 57.29577951, 2) +
               " deg, at most 75 can be used (20 to 45 are best)";
    std::vector<cv::Point2f> points;
    for (const Eigen::Vector2d& p : found.pixels)
        points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    const cv::Rect part = part_around(points, 0) & cv::Rect(0, 0, image.cols, image.rows);
    const double pitch = (*scale)[0] * board.pitch_mm;
    if (part.width < kReach || part.height < kReach) return "";
    const auto sigma = edge_sigma_px(image(part));
    if (sigma && *sigma > kWidestPx && *sigma > kWidestOfPitch * pitch)
        return "blur: the board's edges are " + short_number(*sigma, 2) +
               " px wide (standard deviation) at a pitch of " + short_number(pitch, 3) +
               " px: focus, or hold the board still";
    return "";
}

std::string oblique_if_found_stretched(const cv::Mat& image, const Finder& find,
                                       double longest_px) {
    const cv::Mat small = shrunk(image, longest_px);
    for (const cv::Mat& straight : {small, turned(small)})
        for (const bool rows : {true, false}) {
            cv::Mat stretched;
            cv::resize(straight, stretched, cv::Size(), rows ? kStretch : 1, rows ? 1 : kStretch,
                       cv::INTER_LINEAR);
            if (find(stretched))
                return "too oblique: the board is found only when the picture is stretched three "
                       "times; tilt it by 20 to 45 deg";
        }
    return "";
}

std::string blur_of_picture(const cv::Mat& image) {
    const auto sigma = edge_sigma_px(image);
    const double limit =
        std::max(kPictureWidestPx, kPictureWidestShare * std::max(image.cols, image.rows));
    if (!sigma || *sigma <= limit) return "";
    return "blur: even the sharpest edges of the picture are " + short_number(*sigma, 2) +
           " px wide (standard deviation), at most " + short_number(limit, 2) +
           " can be used: focus, or hold the board still";
}

std::string glare_near(const cv::Mat& image, const cv::Rect& part) {
    const auto spot = saturated_spot(image);
    if (!spot || (*spot & part).area() == 0) return "";
    return "glare: a spot of " + std::to_string(spot->width) + " x " +
           std::to_string(spot->height) + " px at (" + std::to_string(spot->x) + ", " +
           std::to_string(spot->y) +
           ") is saturated and hides corners: move the lamp, or tilt the board";
}

cv::Rect part_around(const std::vector<cv::Point2f>& points, double margin_px) {
    const cv::Rect box = cv::boundingRect(points);
    const int grow = static_cast<int>(std::ceil(margin_px));
    return {box.x - grow, box.y - grow, box.width + 2 * grow, box.height + 2 * grow};
}

}  // namespace stria

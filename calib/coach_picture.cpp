#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "calib/coach.h"
#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kImageWide = 640;  ///< px of the drawing
constexpr double kBarAt = 690, kBarWide = 40, kMargin = 10;

std::string format(const char* how, double a, double b = 0, double c = 0, double d = 0) {
    char text[256];
    std::snprintf(text, sizeof text, how, a, b, c, d);
    return text;
}

/// The rectangle through the board's outermost points, from the first one along the columns.
std::array<Eigen::Vector3d, 4> outline(const Board& board) {
    const auto points = board_points(board);
    Eigen::Vector3d low = points.front(), high = low;
    for (const auto& p : points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    return {low, {high.x(), low.y(), 0}, high, {low.x(), high.y(), 0}};
}

/// Points of a board's outline in the drawing, sides in pieces because lenses bend them.
std::string outline_points(const CameraModel& camera, const Board& board, const Rigid3& pose,
                           double scale) {
    const auto corners = outline(board);
    constexpr int kPieces = 8;
    std::string text;
    for (std::size_t side = 0; side < 4; ++side)
        for (int k = 0; k < kPieces; ++k) {
            const double t = double(k) / kPieces;
            const Eigen::Vector3d p = (1 - t) * corners[side] + t * corners[(side + 1) % 4];
            if (const auto pixel = project(camera, pose * p))
                text += format("%.1f,%.1f ", kMargin + scale * pixel->x(),
                               kMargin + scale * pixel->y());
        }
    return text;
}

/// Depths (mm) of a board's nearest and farthest outline corner.
Eigen::Vector2d depths(const Board& board, const Rigid3& pose) {
    Eigen::Vector2d range(1e300, -1e300);
    for (const auto& corner : outline(board)) {
        const double z = (pose * corner).z();
        range = {std::min(range[0], z), std::max(range[1], z)};
    }
    return range;
}

}  // namespace

std::string Coach::picture(const CoachAdvice& advice) const {
    const CameraModel& camera = model_.channels.front().camera;
    const double scale = kImageWide / camera.width, high = scale * camera.height;
    Eigen::Vector2d all(options_.near_mm, options_.far_mm);
    for (const Rigid3& pose : taken_) {
        const Eigen::Vector2d range = depths(board_, pose);
        all = {std::min(all[0], range[0]), std::max(all[1], range[1])};
    }
    const Eigen::Vector2d wanted = depths(board_, advice.camera_from_board);
    all = {std::min(all[0], wanted[0]), std::max(all[1], wanted[1])};
    const auto bar_y = [&](double depth) {  // far is up
        return kMargin + high * (all[1] - depth) / (all[1] - all[0]);
    };

    std::string svg = format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %.0f %.0f\" "
        "font-family=\"sans-serif\" font-size=\"14\">\n",
        kBarAt + kBarWide + 70, high + 2 * kMargin + 45);
    svg += format(
        "<clipPath id=\"image\"><rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>"
        "</clipPath>\n",
        kMargin, kMargin, kImageWide, high);
    svg += format(
        "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"#f4f4f4\" "
        "stroke=\"#000\"/>\n",
        kMargin, kMargin, kImageWide, high);
    svg += format(
        "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"#f4f4f4\" "
        "stroke=\"#000\"/>\n",
        kBarAt, kMargin, kBarWide, high);
    const auto board = [&](const Rigid3& pose, const char* style) {
        svg += "<polygon clip-path=\"url(#image)\" points=\"" +
               outline_points(camera, board_, pose, scale) + "\" " + style + "/>\n";
        const Eigen::Vector2d range = depths(board_, pose);
        svg += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" ", kBarAt,
                      bar_y(range[1]), kBarWide, std::max(2.0, bar_y(range[0]) - bar_y(range[1]))) +
               style + "/>\n";
    };
    for (const Rigid3& pose : taken_)
        board(pose, "fill=\"#888\" fill-opacity=\"0.15\" stroke=\"#888\"");
    board(advice.camera_from_board,
          "fill=\"#d00\" fill-opacity=\"0.12\" stroke=\"#d00\" stroke-width=\"3\"");
    if (const auto first = project(camera, advice.camera_from_board * outline(board_)[0]))
        svg += format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"7\" fill=\"#d00\"/>\n",
                      kMargin + scale * first->x(), kMargin + scale * first->y());
    svg += format("<text x=\"%.1f\" y=\"%.1f\">%.0f mm</text>\n", kBarAt + kBarWide + 5,
                  kMargin + 12, all[1]);
    svg += format("<text x=\"%.1f\" y=\"%.1f\">%.0f mm</text>\n", kBarAt + kBarWide + 5,
                  kMargin + high, all[0]);
    svg += format("<text x=\"%.1f\" y=\"%.1f\" font-size=\"12\">", kMargin, kMargin + high + 22);
    svg += "View " + std::to_string(taken_.size() + 1) + ": " +
           describe_placement(camera, board_, advice.camera_from_board) + "</text>\n";
    svg += format("<text x=\"%.1f\" y=\"%.1f\">", kMargin, kMargin + high + 42);
    svg += "Dot: the board's first corner. Weakest so far: " + advice.weakest + "</text>\n</svg>\n";
    return svg;
}

}  // namespace stria

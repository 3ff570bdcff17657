#include "calib/board_drawing.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "calib/board_shapes.h"

namespace stria {
namespace {

constexpr double kMaxSidePx = 20000;

/// Share of [x, x + 1] that lies within [from, to].
double overlap(double x, double from, double to) {
    return std::clamp(std::min(x + 1, to) - std::max(x, from), 0.0, 1.0);
}

/// Coverage of every pixel of a picture, pixel (x, y) spanning [x, x + 1] x [y, y + 1] here.
class Coverage {
  public:
    Coverage(int width, int height)
        : width_(width),
          height_(height),
          values_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0F) {}

    void add_rect(double x0, double y0, double x1, double y1) {
        for (int y = first(y0); y < end(y1, height_); ++y)
            for (int x = first(x0); x < end(x1, width_); ++x)
                at(x, y) += static_cast<float>(overlap(x, x0, x1) * overlap(y, y0, y1));
    }

    /// 64 chords a pixel row: the area is exact to about 1e-3 of a pixel.
    void add_disc(double cx, double cy, double radius) {
        constexpr int kChords = 64;
        for (int y = first(cy - radius); y < end(cy + radius, height_); ++y)
            for (int i = 0; i < kChords; ++i) {
                const double dy = y + (i + 0.5) / kChords - cy;
                if (std::abs(dy) >= radius) continue;
                const double half = std::sqrt(radius * radius - dy * dy);
                for (int x = first(cx - half); x < end(cx + half, width_); ++x)
                    at(x, y) += static_cast<float>(overlap(x, cx - half, cx + half) / kChords);
            }
    }

    GreyImage image() const {
        GreyImage picture(width_, height_);
        for (std::size_t i = 0; i < values_.size(); ++i)
            picture.values[i] = static_cast<std::uint8_t>(
                std::lround(255.0 * (1.0 - std::clamp(values_[i], 0.0F, 1.0F))));
        return picture;
    }

  private:
    static int first(double from) { return std::max(0, static_cast<int>(std::floor(from))); }
    static int end(double to, int limit) {
        return std::min(limit, static_cast<int>(std::ceil(to)));
    }
    float& at(int x, int y) {
        return values_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(x)];
    }
    int width_, height_;
    std::vector<float> values_;
};

Eigen::Vector2i picture_size_px(const Board& board, double px_per_mm, double margin_mm) {
    if (!(px_per_mm > 0) || !std::isfinite(px_per_mm))
        throw std::invalid_argument("px_per_mm = " + std::to_string(px_per_mm) +
                                    ": expected above 0");
    if (!(margin_mm >= 0) || !std::isfinite(margin_mm))
        throw std::invalid_argument("margin_mm = " + std::to_string(margin_mm) +
                                    ": expected 0 or more");
    const Eigen::Vector2d size =
        px_per_mm * (pattern_size_mm(board).array() + 2 * margin_mm).matrix();
    if (size.maxCoeff() > kMaxSidePx)
        throw std::invalid_argument("px_per_mm = " + std::to_string(px_per_mm) +
                                    ": the picture would have " + std::to_string(size.maxCoeff()) +
                                    " px, at most 20000 allowed");
    // An exact multiple must not gain a pixel from rounding.
    return (size.array() - 1e-9).ceil().cast<int>().max(1).matrix();
}

}  // namespace

GreyImage draw_board(const Board& board, double px_per_mm, double margin_mm) {
    const Eigen::Vector2i size = picture_size_px(board, px_per_mm, margin_mm);
    const BoardShapes shapes = board_shapes(board);
    const Eigen::Vector2d corner = picture_corner_mm(board, margin_mm);
    const auto px_x = [&](double mm) { return (mm - corner.x()) * px_per_mm; };
    const auto px_y = [&](double mm) { return (mm - corner.y()) * px_per_mm; };

    Coverage coverage(size.x(), size.y());
    for (const BoardRect& rect : shapes.rects)
        coverage.add_rect(px_x(rect.x), px_y(rect.y), px_x(rect.x + rect.width),
                          px_y(rect.y + rect.height));
    for (const BoardDisc& disc : shapes.discs)
        coverage.add_disc(px_x(disc.x), px_y(disc.y), disc.radius * px_per_mm);
    return coverage.image();
}

Eigen::Vector2d board_origin_px(const Board& board, double px_per_mm, double margin_mm) {
    const Eigen::Vector2d corner = picture_corner_mm(board, margin_mm);
    return (-px_per_mm * corner).array() - 0.5;
}

Eigen::Vector2d picture_corner_mm(const Board& board, double margin_mm) {
    double pattern_corner = 0;  // ChArUco: the origin is the pattern's corner
    if (board.kind == BoardKind::chessboard) pattern_corner = -board.pitch_mm;
    if (board.kind == BoardKind::circles || board.kind == BoardKind::acircles)
        pattern_corner = -0.5 * board.pitch_mm;
    return Eigen::Vector2d::Constant(pattern_corner - margin_mm);
}

Eigen::Vector2d picture_size_mm(const Board& board, double px_per_mm, double margin_mm) {
    return picture_size_px(board, px_per_mm, margin_mm).cast<double>() / px_per_mm;
}

}  // namespace stria

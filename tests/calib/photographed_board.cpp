#include "tests/calib/photographed_board.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "calib/board_drawing.h"

namespace stria {
namespace {

constexpr int kFine = 3;  // samples a pixel along each axis

struct Light {
    double grey = 0, red = 0;  // DN of the scene, and of the laser in the red channel
};

class BoardScene {
  public:
    BoardScene(const Board& board, const Rigid3& pose, const PhotographOptions& options)
        : pose_(pose), options_(options) {
        const Eigen::Vector2d size = pattern_size_mm(board);
        px_per_mm_ = 2400.0 / size.maxCoeff();
        picture_ = draw_board(board, px_per_mm_, options.margin_mm);
        origin_ = board_origin_px(board, px_per_mm_, options.margin_mm);
    }

    Light seen_along(const Eigen::Vector3d& ray) const {
        const Eigen::Vector3d normal = pose_.rotation.col(2);
        const double depth = normal.dot(pose_.translation) / normal.dot(ray);
        if (!(depth > 0)) return {options_.background, 0};
        const Eigen::Vector3d point = depth * ray;
        const Eigen::Vector3d on_board = pose_.rotation.transpose() * (point - pose_.translation);
        const Eigen::Vector2d at = origin_ + px_per_mm_ * on_board.head<2>();
        const int x = static_cast<int>(std::lround(std::clamp(at.x(), -2.0, 1e6)));
        const int y = static_cast<int>(std::lround(std::clamp(at.y(), -2.0, 1e6)));
        if (x < 0 || y < 0 || x >= picture_.width || y >= picture_.height)
            return {options_.background, 0};
        const double share = picture_.at(x, y) / 255.0;
        const double grey = options_.black + share * (options_.white - options_.black);
        if (!options_.sheet) return {grey, 0};
        const double off = options_.sheet->normal.dot(point) - options_.sheet->offset_mm;
        const double bell = std::exp(-0.5 * std::pow(off / options_.stripe_sigma_mm, 2));
        return {grey, options_.laser_dn * bell * (0.15 + 0.85 * share)};
    }

  private:
    const Rigid3& pose_;
    const PhotographOptions& options_;
    GreyImage picture_;
    double px_per_mm_ = 1;
    Eigen::Vector2d origin_;
};

using Plane = std::vector<double>;

void blur_along(Plane& plane, int width, int height, bool rows, const std::vector<double>& kernel) {
    const int half = static_cast<int>(kernel.size() / 2);
    const Plane from = plane;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            double sum = 0;
            for (int k = -half; k <= half; ++k) {
                const int xs = rows ? std::clamp(x + k, 0, width - 1) : x;
                const int ys = rows ? y : std::clamp(y + k, 0, height - 1);
                sum += kernel[static_cast<std::size_t>(k + half)] *
                       from[static_cast<std::size_t>(ys * width + xs)];
            }
            plane[static_cast<std::size_t>(y * width + x)] = sum;
        }
}

void blur(Plane& plane, int width, int height, double sigma) {
    if (!(sigma > 0)) return;
    const int half = static_cast<int>(std::ceil(4 * sigma));
    std::vector<double> kernel;
    double sum = 0;
    for (int k = -half; k <= half; ++k)
        sum += kernel.emplace_back(std::exp(-0.5 * std::pow(k / sigma, 2)));
    for (double& value : kernel) value /= sum;
    blur_along(plane, width, height, true, kernel);
    blur_along(plane, width, height, false, kernel);
}

}  // namespace

ColourImage photograph(const CameraModel& camera, const Rigid3& camera_from_board,
                       const Board& board, const PhotographOptions& options) {
    const BoardScene scene(board, camera_from_board, options);
    const int width = camera.width, height = camera.height;
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    Plane grey(pixels), red(pixels);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto i = static_cast<std::size_t>(y * width + x);
            if (x >= options.hidden_from) {
                grey[i] = options.background;
                continue;
            }
            for (int k = 0; k < kFine * kFine; ++k) {
                const Eigen::Vector2d at(x + (k % kFine + 0.5) / kFine - 0.5,
                                         y + (k / kFine + 0.5) / kFine - 0.5);
                const Light light = scene.seen_along(ray_through(camera, at));
                grey[i] += light.grey / (kFine * kFine);
                red[i] += light.red / (kFine * kFine);
            }
        }
    blur(grey, width, height, options.blur_px);
    blur(red, width, height, options.blur_px);
    std::mt19937 rng(options.seed);
    std::normal_distribution<double> noise(0, options.noise_dn);
    ColourImage image(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto i = static_cast<std::size_t>(y * width + x);
            const double from_lamp = (Eigen::Vector2d(x, y) - options.glare_at).norm();
            const double lamp =
                options.glare_dn * std::exp(-0.5 * std::pow(from_lamp / options.glare_px, 2));
            for (int c = 0; c < 3; ++c) {
                const double light = grey[i] + lamp + (c == 0 ? red[i] : 0.0) + noise(rng);
                image.at(x, y, c) =
                    static_cast<std::uint8_t>(std::clamp(std::lround(light), 0L, 255L));
            }
        }
    return image;
}

GreyImage grey_photograph(const CameraModel& camera, const Rigid3& camera_from_board,
                          const Board& board, const PhotographOptions& options) {
    const ColourImage colour = photograph(camera, camera_from_board, board, options);
    GreyImage grey(colour.width, colour.height);
    for (int y = 0; y < colour.height; ++y)
        for (int x = 0; x < colour.width; ++x) grey.at(x, y) = colour.at(x, y, 1);
    return grey;
}

Rigid3 board_at(const Board& board, const Eigen::Vector3d& centre, const Eigen::Vector3d& turn) {
    const auto points = board_points(board);
    const Eigen::Vector3d middle = 0.5 * (points.front() + points.back());
    const Eigen::Matrix3d rotation = rotation_from_vector(turn);
    return {rotation, centre - rotation * middle};
}

}  // namespace stria

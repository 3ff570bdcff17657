#include "host/render/range_picture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace stria {
namespace {

int reduction(int width, int height, int max_side) {
    return std::max(1, (std::max(width, height) + max_side - 1) / std::max(max_side, 1));
}

void set_pixel(ColourImage& picture, int x, int y, const Eigen::Vector3f& colour) {
    for (int c = 0; c < 3; ++c)
        picture.at(x, y, c) =
            static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(colour[c], 0.0f, 1.0f)));
}

/// Share of light that a surface with this slope sends to the eye; 1 face on.
float shade(const Eigen::Vector3f& normal, const Eigen::Vector3f& towards_eye) {
    const float length = normal.norm();
    if (length < 1e-6f) return 1.0f;
    return 0.35f + 0.65f * std::abs(normal.dot(towards_eye)) / length;
}

}  // namespace

ColourImage picture_of_values(int width, int height, const std::vector<float>& values,
                              const std::vector<std::uint8_t>& mask, const ColourScale& scale,
                              int max_side) {
    const auto cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    if (values.size() != cells || mask.size() != cells)
        throw std::invalid_argument("picture_of_values: " + std::to_string(values.size()) +
                                    " values, " + std::to_string(mask.size()) +
                                    " mask cells: expected " + std::to_string(cells));
    const int step = reduction(width, height, max_side);
    ColourImage picture(width / step, height / step, 3, 255);
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            Eigen::Vector3f sum = Eigen::Vector3f::Zero();
            int count = 0;
            for (int dy = 0; dy < step; ++dy) {
                for (int dx = 0; dx < step; ++dx) {
                    const std::size_t i =
                        static_cast<std::size_t>(y * step + dy) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(x * step + dx);
                    if (!mask[i]) continue;
                    sum += colour_of(scale, values[i]);
                    ++count;
                }
            }
            if (count > 0) set_pixel(picture, x, y, sum / static_cast<float>(count));
        }
    }
    return picture;
}

RangePicture picture_of_range(const RangeImage& image, int max_side) {
    double low = 0, high = 0;
    bool any = false;
    for (std::size_t i = 0; i < image.cell_count(); ++i) {
        if (!image.mask[i]) continue;
        const double z = image.points[i].position.z();
        low = any ? std::min(low, z) : z;
        high = any ? std::max(high, z) : z;
        any = true;
    }
    RangePicture out;
    out.scale = {ColourMap::sequential, low, any && high > low ? high : low + 1, "z in the scan",
                 "mm"};
    const int step = reduction(image.width, image.height, max_side);
    out.picture = ColourImage(image.width / step, image.height / step, 3, 255);
    for (int y = 0; y < out.picture.height; ++y) {
        for (int x = 0; x < out.picture.width; ++x) {
            Eigen::Vector3f sum = Eigen::Vector3f::Zero();
            int count = 0;
            for (int dy = 0; dy < step; ++dy) {
                for (int dx = 0; dx < step; ++dx) {
                    if (!image.has(x * step + dx, y * step + dy)) continue;
                    const RangePoint& p = image.at(x * step + dx, y * step + dy);
                    const Eigen::Vector3f eye = direction_to_camera(image, p).cast<float>();
                    sum += shade(p.normal, eye) * colour_of(out.scale, p.position.z());
                    ++count;
                }
            }
            if (count > 0) set_pixel(out.picture, x, y, sum / static_cast<float>(count));
        }
    }
    return out;
}

ColourImage picture_of_frame(const Frame& frame, double gain, int max_side) {
    const int step = reduction(frame.width, frame.height, max_side);
    ColourImage picture(frame.width / step, frame.height / step, 3);
    const double scale = gain / frame.full_scale();
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            int greatest = 0;  // a mean would thin out the stripe
            for (int dy = 0; dy < step; ++dy)
                for (int dx = 0; dx < step; ++dx)
                    greatest = std::max(greatest, frame.sample(x * step + dx, y * step + dy));
            set_pixel(picture, x, y,
                      Eigen::Vector3f::Constant(static_cast<float>(greatest * scale)));
        }
    }
    return picture;
}

}  // namespace stria

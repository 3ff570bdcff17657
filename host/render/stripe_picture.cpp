#include "host/render/stripe_picture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/render/colour_map.h"
#include "host/render/range_picture.h"

namespace stria {
namespace {

constexpr int kZoom = 3;
constexpr double kBrightest = 170;  // so that the marks stand out from a white stripe
constexpr std::array<std::uint8_t, 3> kGood = {0, 255, 80}, kFlagged = {255, 150, 0};

/// Greatest sample, so that dark sweeps can be seen.
int brightest(const Frame& frame) {
    int most = 1;
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) most = std::max(most, frame.sample(x, y));
    return most;
}

/// Five pixels, so that a picture shown smaller than it is still has them.
void draw_cross(ColourImage& picture, int x, int y, const std::array<std::uint8_t, 3>& colour) {
    constexpr std::array<std::array<int, 2>, 5> kCross = {
        {{0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    for (const auto& [dx, dy] : kCross) {
        const int px = x + dx, py = y + dy;
        if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
        for (int c = 0; c < 3; ++c) picture.at(px, py, c) = colour[static_cast<std::size_t>(c)];
    }
}

}  // namespace

ColourImage picture_of_peaks(const Frame& frame, const std::vector<Pulse>& peaks, bool transposed) {
    const int width = transposed ? frame.height : frame.width;
    const int height = transposed ? frame.width : frame.height;
    ColourImage picture(width * kZoom, height * kZoom, 3);
    const double scale = 255.0 / brightest(frame);
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const int u = x / kZoom, v = y / kZoom;
            const int value = transposed ? frame.sample(v, u) : frame.sample(u, v);
            // A square root brings out the dark parts.
            const double grey = kBrightest * std::sqrt(value * scale / 255.0);
            for (int c = 0; c < 3; ++c)
                picture.at(x, y, c) = static_cast<std::uint8_t>(std::min(grey, kBrightest));
        }
    }
    for (const Pulse& peak : peaks) {
        const double u = transposed ? peak.v : peak.u, v = transposed ? peak.u : peak.v;
        const int x = static_cast<int>(std::lround((u + 0.5) * kZoom - 0.5));
        const int y = static_cast<int>(std::lround((v + 0.5) * kZoom - 0.5));
        draw_cross(picture, x, y, peak.flags == 0 ? kGood : kFlagged);
    }
    return picture;
}

ColourImage picture_of_pulses(const PulseMap& map, int max_side) {
    const auto cells = static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
    std::vector<float> seconds(cells, 0.0f);
    std::vector<std::uint8_t> mask(cells, 0);
    TimeNs first = 0, last = 0;
    for (const Pulse& p : map.pulses) {
        if (&p == map.pulses.data()) first = last = p.t_ns;
        first = std::min(first, p.t_ns);
        last = std::max(last, p.t_ns);
    }
    for (std::size_t i = 0; i < cells; ++i) {
        if (map.cell_begin[i] == map.cell_begin[i + 1]) continue;
        mask[i] = 1;
        seconds[i] = static_cast<float>(
            1e-9 * static_cast<double>(map.pulses[map.cell_begin[i]].t_ns - first));
    }
    const ColourScale scale = {ColourMap::sequential, 0, 1e-9 * static_cast<double>(last - first),
                               "time", "s"};
    return picture_of_values(map.width, map.height, seconds, mask, scale, max_side);
}

}  // namespace stria

#include "host/cli/stripe_colour.h"
#include "firmware/core/median.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace stria {
namespace {

constexpr double kLeastShare = 0.25;    // of the peak's height: red lasers in photographs 0.4 to 1
constexpr double kNearlyClipped = 0.9;  // of full scale; JPEG smears what was clipped
constexpr int kSideReach = 8;           // px of background on either side
constexpr int kRows = 2;                // averaged above and below, against noise

int excess_over_others(const std::uint16_t* rgb, int channel) {
    return rgb[channel] - std::max(rgb[(channel + 1) % 3], rgb[(channel + 2) % 3]);
}

}  // namespace

ColourChannel laser_colour(const LoadedImage& image) {
    if (image.pixels.channels != 3) return ColourChannel::grey;
    const std::vector<std::uint16_t>& values = image.pixels.values;
    constexpr std::array kNames = {ColourChannel::red, ColourChannel::green, ColourChannel::blue};
    ColourChannel best = ColourChannel::grey;
    int greatest = ((1 << image.bits) - 1) / 50;
    std::vector<int> excess(values.size() / 3);
    const auto high = static_cast<std::ptrdiff_t>(excess.size() - 1 - excess.size() / 1000);
    for (int channel = 0; channel < 3 && !excess.empty(); ++channel) {
        for (std::size_t i = 0; i < excess.size(); ++i)
            excess[i] = excess_over_others(&values[3 * i], channel);
        std::nth_element(excess.begin(), excess.begin() + high, excess.end());
        if (excess[static_cast<std::size_t>(high)] <= greatest) continue;
        greatest = excess[static_cast<std::size_t>(high)];
        best = kNames[static_cast<std::size_t>(channel)];
    }
    return best;
}

LaserColour::LaserColour(LoadedImage image, ColourChannel laser, bool columns)
    : image_(std::move(image)), columns_(columns) {
    if (image_.pixels.channels != 3) return;
    if (laser == ColourChannel::red) laser_ = 0;
    if (laser == ColourChannel::green) laser_ = 1;
    if (laser == ColourChannel::blue) laser_ = 2;
    width_ = columns ? image_.pixels.height : image_.pixels.width;
    height_ = columns ? image_.pixels.width : image_.pixels.height;
}

double LaserColour::level(int x, int y) const {
    const int value = columns_ ? image_.pixels.at(y, x, laser_) : image_.pixels.at(x, y, laser_);
    return value / static_cast<double>((1 << image_.bits) - 1);
}

double LaserColour::excess(int x, int y) const {
    if (columns_) std::swap(x, y);
    return std::max(0, excess_over_others(&image_.pixels.at(x, y), laser_));
}

double LaserColour::excess_of_rows(int x, int y) const {
    const int first = std::max(0, y - kRows), last = std::min(height_ - 1, y + kRows);
    double sum = 0;
    for (int row = first; row <= last; ++row) sum += excess(x, row);
    return sum / (last - first + 1);
}

bool LaserColour::has(const Pulse& peak) const {
    if (laser_ < 0) return true;
    const double width = std::max(1.0, static_cast<double>(peak.width));
    const int x = static_cast<int>(std::lround(peak.u)), y = static_cast<int>(peak.v);
    const int core = static_cast<int>(std::ceil(1.5 * width)) + 1;
    const int side = static_cast<int>(std::ceil(4 * width)) + 2;
    const auto in_row = [&](int at) { return std::clamp(at, 0, width_ - 1); };

    bool clipped = false;
    double greatest = 0;  // of this row alone: colour that is left beside clipped samples
    for (int at = in_row(x - core); at <= in_row(x + core); ++at) {
        clipped = clipped || level(at, y) >= kNearlyClipped;
        greatest = std::max(greatest, excess(at, y));
    }
    std::vector<double> beside;
    for (int at = x - side - kSideReach; at <= x + side + kSideReach; ++at)
        if (at >= 0 && at < width_ && std::abs(at - x) >= side)
            beside.push_back(excess_of_rows(at, y));
    const double background = median(beside);
    double rise = greatest - background;
    if (!clipped) {  // height of the peak's own Gaussian in the excess
        double along = 0, norm = 0;
        for (int at = in_row(x - 2 * core); at <= in_row(x + 2 * core); ++at) {
            const double shape =
                std::exp(-0.5 * std::pow((at - static_cast<double>(peak.u)) / width, 2));
            along += shape * (excess_of_rows(at, y) - background);
            norm += shape * shape;
        }
        rise = norm > 0 ? along / norm : 0;
    }
    return rise >= kLeastShare * peak.amplitude;
}

}  // namespace stria

#include "sim/lens.h"

#include <algorithm>
#include <cmath>

namespace stria {
namespace {

/// Index of a row or column beyond the border, reflected; reaches of more than the picture's size
/// end at the border.
int reflected(int i, int count) {
    if (i < 0) i = -1 - i;
    if (i >= count) i = 2 * count - 1 - i;
    return std::clamp(i, 0, count - 1);
}

}  // namespace

double spot_sigma_px(const Scene& scene, double z_mm) {
    const SceneLens& lens = scene.lens;
    double defocus_px = 0;
    if (lens.focus_mm > 0 && z_mm > 0) {
        const double pixel_mm = scene.sensor.pixel_um * 1e-3;
        const double f = scene.channel.camera.fx * pixel_mm;
        const double circle_mm = f / scene.sensor.f_number * f * std::abs(z_mm - lens.focus_mm) /
                                 (z_mm * (lens.focus_mm - f));
        defocus_px = circle_mm / pixel_mm / 4;
    }
    return std::hypot(lens.psf_sigma_px, defocus_px);
}

std::vector<float> discrete_gaussian(double sigma_px) {
    const double t = sigma_px * sigma_px;
    double sum = 0;
    // Scaled Bessel functions by downward recurrence I_{n-1} = I_{n+1} + (2 n / t) I_n, which is
    // stable; started far in the tail and normalised by their sum.
    const int last = static_cast<int>(std::ceil(6 * sigma_px)) + 8;
    if (t < 1e-8) return {1.0F};
    std::vector<double> bessel(static_cast<std::size_t>(last) + 2, 0.0);
    bessel[static_cast<std::size_t>(last)] = 1e-280;
    for (int n = last; n > 0; --n) {
        const auto at = static_cast<std::size_t>(n);
        bessel[at - 1] = bessel[at + 1] + 2 * n / t * bessel[at];
        if (bessel[at - 1] > 1e250)
            for (double& value : bessel) value *= 1e-250;
    }
    for (std::size_t n = 0; n < bessel.size(); ++n) sum += (n > 0 ? 2 : 1) * bessel[n];
    std::size_t size = bessel.size();
    while (size > 1 && bessel[size - 1] < 1e-8 * sum) --size;
    sum = bessel[0];
    for (std::size_t n = 1; n < size; ++n) sum += 2 * bessel[n];
    std::vector<float> kernel(size);
    for (std::size_t n = 0; n < size; ++n) kernel[n] = static_cast<float>(bessel[n] / sum);
    return kernel;
}

std::vector<float> vignetting(const Scene& scene) {
    const CameraModel& camera = scene.channel.camera;
    const double far_x = std::max(camera.cx, camera.width - 1 - camera.cx);
    const double far_y = std::max(camera.cy, camera.height - 1 - camera.cy);
    const double corner2 = far_x * far_x + far_y * far_y;
    std::vector<float> share;
    share.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            const double dx = x - camera.cx, dy = y - camera.cy;
            double passed = 1 - scene.lens.corner_loss * (dx * dx + dy * dy) / corner2;
            if (scene.lens.cos4) {
                const double tan2 = std::pow(dx / camera.fx, 2) + std::pow(dy / camera.fy, 2);
                passed /= (1 + tan2) * (1 + tan2);
            }
            share.push_back(static_cast<float>(passed));
        }
    }
    return share;
}

SpotSpread::SpotSpread() {
    const int count = static_cast<int>(kMostSigma) * kStepsPerPx;
    for (int i = 0; i <= count; ++i)
        kernels_.push_back(discrete_gaussian(static_cast<double>(i) / kStepsPerPx));
}

std::uint16_t SpotSpread::index_of(double sigma_px) {
    return static_cast<std::uint16_t>(
        std::lround(std::clamp(sigma_px, 0.0, kMostSigma) * kStepsPerPx));
}

void SpotSpread::gather(std::span<const float> light, std::span<const std::uint16_t> spots,
                        int width, int height, int row_begin, int row_end,
                        std::span<float> out) const {
    const int reach = static_cast<int>(kernels_.back().size());
    const int first = std::max(0, row_begin - reach), last = std::min(height, row_end + reach);
    for (int y = first; y < last; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                   static_cast<std::size_t>(x);
            if (light[at] == 0) continue;
            const std::vector<float>& kernel = kernels_[spots[at]];
            const int radius = static_cast<int>(kernel.size()) - 1;
            for (int dy = -radius; dy <= radius; ++dy) {
                const int row = reflected(y + dy, height);
                if (row < row_begin || row >= row_end) continue;
                const float of_row = light[at] * kernel[static_cast<std::size_t>(std::abs(dy))];
                float* const target = out.data() + static_cast<std::ptrdiff_t>(row - row_begin) *
                                                       static_cast<std::ptrdiff_t>(width);
                for (int dx = -radius; dx <= radius; ++dx)
                    target[reflected(x + dx, width)] +=
                        of_row * kernel[static_cast<std::size_t>(std::abs(dx))];
            }
        }
    }
}

}  // namespace stria

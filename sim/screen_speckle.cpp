#include "sim/screen_speckle.h"

#include <algorithm>
#include <cmath>

#include "host/geometry/parallel.h"
#include "sim/coherent_speckle.h"
#include "sim/random.h"

namespace stria {
namespace {

constexpr int kTile = 128;  ///< px

}  // namespace

double speckle_px(const Scene& scene) {
    return scene.channel.sheet.wavelength_nm * 1e-3 * scene.sensor.f_number / scene.sensor.pixel_um;
}

std::vector<float> screen_speckle(const Scene& scene, std::uint64_t seed) {
    const int width = scene.channel.camera.width, height = scene.channel.camera.height;
    CoherentView view{
        .wavelength_nm = scene.channel.sheet.wavelength_nm, .columns = kTile, .rows = kTile};
    view.pixel_mm = view.wavelength_nm * 1e-6 / (2 * view.sin_u) / speckle_px(scene);
    const double contrast = scene.speckle.contrast;
    const double polarisation = std::sqrt(std::max(0.0, 2 * contrast * contrast - 1));

    std::vector<float> gain(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    const int across = (width + kTile - 1) / kTile, down = (height + kTile - 1) / kTile;
    const auto add_tile = [&](int tile, int pattern, double share) {
        const std::uint64_t own = counter_random::bits(
            seed, counter_random::kScreenSpeckle, static_cast<std::uint64_t>(2 * tile + pattern));
        const CoherentSurface screen(view, own);
        const std::vector<double> light = screen.pixels_of(screen.evenly_lit());
        const int left = tile % across * kTile, top = tile / across * kTile;
        for (int y = top; y < std::min(height, top + kTile); ++y)
            for (int x = left; x < std::min(width, left + kTile); ++x)
                gain[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                     static_cast<std::size_t>(x)] +=
                    static_cast<float>(
                        share * light[static_cast<std::size_t>((y - top) * kTile + x - left)]);
    };
    parallel_for_blocks(static_cast<std::size_t>(across * down), 1,
                        [&](std::size_t begin, std::size_t end) {
                            for (std::size_t tile = begin; tile < end; ++tile) {
                                add_tile(static_cast<int>(tile), 0, (1 + polarisation) / 2);
                                if (polarisation < 1)
                                    add_tile(static_cast<int>(tile), 1, (1 - polarisation) / 2);
                            }
                        });
    return gain;
}

}  // namespace stria

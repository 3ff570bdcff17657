#include "sim/pixel_pattern.h"

#include <algorithm>

#include "sim/lens.h"
#include "sim/random.h"

namespace stria {

PixelPattern pixel_pattern(const Scene& scene, std::uint64_t seed) {
    const CameraModel& camera = scene.channel.camera;
    const auto pixels =
        static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
    PixelPattern pattern;
    if (scene.lens.cos4 || scene.lens.corner_loss > 0) pattern.gain = vignetting(scene);
    if (scene.sensor.prnu > 0) {
        pattern.gain.resize(pixels, 1.0F);
        for (std::size_t i = 0; i < pixels; ++i) {
            const double own = counter_random::normal(seed, counter_random::kPixelGain, i);
            pattern.gain[i] *= static_cast<float>(std::max(0.0, 1 + scene.sensor.prnu * own));
        }
    }
    if (scene.sensor.dsnu_e > 0) {
        pattern.offset_e.resize(pixels);
        for (std::size_t i = 0; i < pixels; ++i)
            pattern.offset_e[i] = static_cast<float>(
                scene.sensor.dsnu_e * counter_random::normal(seed, counter_random::kPixelDark, i));
    }
    return pattern;
}

}  // namespace stria

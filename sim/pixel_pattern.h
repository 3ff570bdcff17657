#pragma once
#include <cstdint>
#include <vector>

#include "sim/scene.h"

namespace stria {

/// What distinguishes one pixel from the next and stays the same for every frame; empty vectors
/// where nothing does.
struct PixelPattern {
    /// Electrons per electron of an even sensor behind an ideal lens: vignetting times
    /// 1 + prnu x (standard normal of the pixel), at least 0.
    std::vector<float> gain;
    std::vector<float> offset_e;  ///< added after the noise: dsnu_e x (standard normal)
};

PixelPattern pixel_pattern(const Scene& scene, std::uint64_t seed);

}  // namespace stria

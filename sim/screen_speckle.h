#pragma once
#include <cstdint>
#include <vector>

#include "sim/scene.h"

namespace stria {

/// Size of a speckle in the image, lambda N / pixel, px (N = f_number, the working one).
double speckle_px(const Scene& scene);

/// Factor of the laser's light in every pixel, row by row, mean 1: a complex circular Gaussian
/// screen through the lens's circular aperture, squared, averaged over the pixel (CoherentSurface
/// in even light), a pattern that stays in the image of a camera at rest. With contrast C before
/// the pixel the light has the degree of polarisation P = sqrt(2 C^2 - 1): two patterns of shares
/// (1 +- P) / 2 (Goodman, Speckle Phenomena in Optics, 2007, sec. 3.3.5). Tiles of 128 px have
/// patterns of their own: neighbours across their borders do not correlate.
std::vector<float> screen_speckle(const Scene& scene, std::uint64_t seed);

}  // namespace stria

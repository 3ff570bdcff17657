#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "sim/light_shape.h"

namespace stria {

/// What one ray through a pixel says about its light.
struct RayLight {
    double position = 0;  ///< BeamAtPoint::position
    float per_position = 0;
    float per_s = 0;
    float rate = 0;     ///< electrons a second at the beam's centre; 0 if dark or in shadow
    float ambient = 0;  ///< electrons a second
    float speckle = 1;  ///< factor of rate, not yet in it
    std::int16_t object = -1;
    bool judged = false;     ///< the beam is near enough for rate to be known
    std::uint16_t spot = 0;  ///< SpotSpread's index for its depth
};

struct PixelSample {
    RayLight light;
    LightShape shape;
};

/// A piece of a pixel that is alike throughout.
struct PixelPart {
    PixelSample sample;     ///< at its centre; rate and ambient those of a whole pixel of its kind
    double share = 0;       ///< of the pixel's area
    double footprint2 = 0;  ///< variance of the sheet's place over the piece, in beam variances
};

/// Looks through a pixel at places in -0.5..0.5 from its centre (u, v).
using PixelCaster =
    std::function<void(std::span<const Eigen::Vector2d> places, std::span<PixelSample> samples)>;

/// Relative steps between neighbours that count as a border: of ambient light, where targets'
/// corners must be right, and of the laser's, where a slope of 30 % a pixel moves a pulse by 3 % of
/// the pixel's own spread.
inline constexpr float kAmbientStep = 0.1F, kRateStep = 0.3F;
inline bool differs(float a, float b, float step) {
    return std::abs(a - b) > step * std::max(a, b);
}

/// How finely a pixel's footprint is sampled. Halving the steps shows the error of the others.
struct PixelSampling {
    int cells = 4;             ///< a side, where a pixel is uneven
    double part_sigmas = 0.5;  ///< most that a part of a smooth pixel may span along u and along v,
                               ///< beam widths; a cell of an uneven one in all: twice as much
};

/// Cuts a pixel with borders in it into parts, appended; their shares sum to 1. Rays at the corners
/// of `cells` x `cells` squares say which of them a border crosses. There each crossed side is
/// halved to 1/1024 of its length, the border runs straight between the crossings, and either side
/// is what a ray through its centroid sees. Squares are cut in four, up to three times, where the
/// sheet's place spans more than part_sigmas or bends, or where a border is not straight. So the
/// area beside a straight border comes out within 1e-3 of the pixel.
void cut_pixel(const PixelCaster& cast, const PixelSampling& sampling,
               std::vector<PixelPart>& parts);

}  // namespace stria

#pragma once
#include <span>

#include "firmware/core/frame.h"
#include "firmware/core/sensor_noise.h"

namespace stria {

/// Noise of images whose sensor is unknown, as photographs: variance against brightness from the
/// median absolute second difference along rows, read noise and shot noise fitted to it. Texture
/// makes it an upper estimate. Frames without noise give a read noise of 0 (quantisation remains).
SensorNoise estimate_noise(std::span<const Frame> frames);

}  // namespace stria

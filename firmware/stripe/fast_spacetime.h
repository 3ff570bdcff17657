#pragma once
#include <memory>

#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/spacetime_engine.h"

namespace stria {

/// The spacetime analysis of 8-bit frames of a swept stripe for the scanner's processor: SIMD
/// kernels (fast_kernels.h) follow all pixels and fit single clean pulses, many at a time. Windows
/// are exactly the reference's. What a kernel does not judge with certainty (clipped samples, a
/// significant misfit that may be a second pulse, widths below 0.55 frame periods, heights, sigmas
/// and misfits near their limits, the sweep's ends) goes to the reference's own fit, and is
/// counted. Against the reference a pulse differs by at most 0.1 of its sigma and 0.002 frame
/// periods in time.
std::unique_ptr<SpacetimeEngine> make_fast_engine(int width, int height, const SensorNoise& noise,
                                                  const SpacetimeOptions& options);

}  // namespace stria

#pragma once
#include <memory>

#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/spacetime_engine.h"

namespace stria {

/// The spacetime analysis of 8-bit frames of a swept stripe for the scanner's processor: SIMD
/// kernels (fast_kernels.h) follow all pixels and fit single clean pulses, many at a time. Windows
/// are exactly the reference's. What a kernel does not judge with certainty goes to the reference's
/// own fit, and is counted: clipped samples, fits that do not converge, misfits that may be a
/// second pulse, widths below 0.55 frame periods, heights below 8 times the background's noise or
/// near min_snr, sigmas and misfits near their limits, the sweep's ends. Of a pulse that the
/// kernels judge, time differs from the reference's by at most 0.1 of its sigma and 0.002 frame
/// periods, sigma and width by 5 %, amplitude by 0.2 of a sample's noise and 1.5 %, chi-square by 3
/// %; the number of pulses and their flags are the same, but for the flag of a width that is at the
/// limit of its ratio to the median.
/// README.md ("Equal") has the whole list; tests/fuzz and stripe_fast_long_test look for
/// exceptions.
std::unique_ptr<SpacetimeEngine> make_fast_engine(int width, int height, const SensorNoise& noise,
                                                  const SpacetimeOptions& options);

}  // namespace stria

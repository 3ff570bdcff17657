#pragma once
#include "firmware/core/sensor_noise.h"

namespace stria {

/// A Gaussian pulse as samples show it: over frames, or a stripe over pixels. The unit of position
/// is the distance of two samples.
struct SampledPulse {
    double amplitude_dn = 0;     ///< at its centre, before the aperture blurs it
    double width = 1;            ///< standard deviation, samples
    double half_aperture = 0.5;  ///< each sample integrates over +- this
    double background_dn = 0;    ///< light beside the pulse, black level included
    double full_scale_dn = 255;  ///< samples drawn above it only say that they are
};

/// Mean of the pulse, without background, over a sample at `x` from its centre, DN.
double sample_of(const SampledPulse& pulse, double x);

/// Cramer-Rao bound of the pulse's position (samples): square root of [F^-1] with position,
/// amplitude, width and background unknown, F = sum over the samples of J'J / variance, root mean
/// square over where the samples fall. Infinite where the samples do not fix a pulse.
/// Source: accuracy.md A.4, general form; for wide pulses in additive noise it tends to
/// 1.0622 sqrt(width) noise / amplitude. Clipped samples count as far as their being clipped says
/// something. The variance is not taken as a source of information.
double position_bound(const SampledPulse& pulse, const SensorNoise& noise);

/// Highest sample's amplitude over the noise of that sample.
double peak_snr(const SampledPulse& pulse, const SensorNoise& noise);

}  // namespace stria

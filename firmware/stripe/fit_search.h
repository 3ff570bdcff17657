#pragma once
#include <optional>

#include "firmware/stripe/gaussian_fit.h"

namespace stria {

/// The start of greatest likelihood on a grid of places (half a width apart, between the first and
/// the last sample) and widths (a factor of 1.4 apart, within the limits' and the window's length),
/// height and background by weighted linear least squares. A clipped sample counts where the model
/// lies below full scale. Empty if no place has a positive height. `limits` gives the widths'
/// limits, which the start keeps.
std::optional<FitStart> search_start(const FitSamples& samples, const SensorNoise& noise,
                                     double full_scale, const FitStart& limits);

}  // namespace stria

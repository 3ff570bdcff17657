#pragma once
#include <array>
#include <optional>
#include <span>

#include "firmware/core/sensor_noise.h"
#include "firmware/stripe/gaussian_fit.h"

namespace stria {

constexpr int kMaxWindowHalf = 95;  ///< px; 4 x the widest stripe and its sides fit in

/// The samples about one peak, as the methods of peak_methods.h use them: sample t is the one t px
/// from the pixel nearest to the peak, -half <= t <= half.
struct PeakWindow {
    int centre = 0;                  ///< pixel of the row
    int half = 0;                    ///< samples on either side
    double width = 0;                ///< of the stripe, px, as fitted
    double blurred_width = 0;        ///< the pixel's blur included
    double background_variance = 0;  ///< of the background that was subtracted, DN^2
    std::array<double, 2 * kMaxWindowHalf + 1> samples;    ///< DN above the local background
    std::array<double, 2 * kMaxWindowHalf + 1> variances;  ///< DN^2; 0: saturated

    double at(int t) const { return samples[static_cast<std::size_t>(t + half)]; }
    double variance(int t) const { return variances[static_cast<std::size_t>(t + half)]; }
    bool saturated(int t) const { return variance(t) == 0.0; }
};

/// The window about peak k of the fit: 4 blurred widths and four samples of background on either
/// side. The light of the fit's other peak is removed. Empty where the row does not hold it.
std::optional<PeakWindow> peak_window(std::span<const float> row, const SensorNoise& noise,
                                      double full_scale, const GaussianFit& fit, int k);

}  // namespace stria

#pragma once
#include <vector>

#include "tests/firmware/stripe/localisation.h"

namespace stria::test {

/// Pulses over time: every pixel of a frame is one trial.
struct TemporalCondition {
    double width_frames = 1.5;  ///< Gaussian standard deviation
    double snr = 30;
    bool shot = false;
    double jitter = 0.2;    ///< of the frames' times, uniform, +- share of the period
    double saturation = 0;  ///< pulse height over full scale; 0: 2000 DN of 4095, or 200 of 255
    double exposure = 0.8;  ///< share of the period
    bool fast = false;      ///< 8 bits and the SIMD kernels; else 12 bits and the reference
};

LocalisationCell measure_temporal(const TemporalCondition& condition, int trials, unsigned seed);

/// As expect_spatial_reaches_bound, over time, with 20 % jitter of the frames and a rolling
/// shutter.
void expect_temporal_reaches_bound(int trials, const std::vector<double>& snrs);

/// The same of the SIMD kernels, on 8 bits: at most 1.10 at SNR 20 to 50, 1.2 at 10 and 200.
void expect_fast_reaches_bound(int trials, const std::vector<double>& snrs);

}  // namespace stria::test

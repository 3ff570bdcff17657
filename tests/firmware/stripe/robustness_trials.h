#pragma once
#include "tests/firmware/stripe/localisation.h"

namespace stria::test {

/// What goes wrong while pulses pass over the pixels of several sweeps.
struct Disturbance {
    const char* name = "none";
    double drop_probability = 0;  ///< of each frame, independently
    double jitter = 0;            ///< of the frames' times, uniform, +- share of the period
    double ambient = 0;           ///< share of full scale
};

struct RobustnessCell {
    LocalisationCell found;  ///< errors in frame periods, bound over the frames that are there
    int frames_lost = 0;     ///< by the generator, between the first and the last frame sent
    int frames_reported_lost = 0;  ///< PulseMap::frames_dropped
    LocalisationCell hit;          ///< of those with a lost frame within 2 widths of the pulse
};

/// Temporal fits of Gaussian pulses in sweeps of 20 x 10 pixels, at least two, `trials` pulses in
/// all. Half of the noise at the peak is the light's own.
/// @param width_frames  standard deviation of the pulse
RobustnessCell measure_robustness(const Disturbance& disturbance, double width_frames, double snr,
                                  int trials, unsigned seed);

/// Each disturbance and all together, widths 0.8 to 2.5 frames, SNR 20 to 100: error at most 1.1 x
/// the bound of that condition (those with a lost frame in them also by
/// themselves, but for the shortest and dimmest), bias below
/// 0.02 of the pulse's width, every lost frame reported. Prints a table. Where `trials` are few,
/// three standard deviations of sampling are granted.
void expect_robust(int trials);

}  // namespace stria::test

#pragma once
#include <string>
#include <vector>

#include "firmware/stripe/spacetime.h"
#include "tests/firmware/stripe/localisation.h"

namespace stria::test {

/// A sweep of 8-bit frames with every kind of pixel: one pulse, two, none, clipped, dim, too wide.
struct FastCase {
    int width = 150, height = 24, frames = 90;
    double width_frames = 1.5;
    double height_dn = 160, background_dn = 18;
    double snr = 40;
    double jitter = 0.2;
    double exposure = 0.8;     ///< share of the period
    double odd_pixels = 0.15;  ///< share that is not one clean pulse
    unsigned seed = 1;
};

struct FastSweep {
    std::vector<Frame> frames;
    SensorNoise noise;
};
FastSweep make_sweep(const FastCase& of);

/// What an analyser makes of a sweep.
struct Analysed {
    PulseMap map;
    SweepSampling sampling;
    WindowCounts windows;
    int most_frames = 0;
};
Analysed analyse(const FastSweep& sweep, const SpacetimeOptions& options);

/// Greatest differences of the pulses of two maps that have equal numbers of them in every cell.
struct Differences {
    std::size_t cells = 0;  ///< whose number of pulses differs
    std::size_t pulses = 0;
    double time_sigmas = 0;       ///< in the reference's sigma
    double time_frames = 0;       ///< in frame periods
    double width = 0, sigma = 0;  ///< relative
    double amplitude_sigmas = 0;  ///< noise of the amplitude, roughly: the sample's at its peak
    double background_sigmas = 0;
    double chi_square = 0;  ///< relative, where it exceeds 1
    std::size_t flags = 0;  ///< pulses whose flags, laser or exposure differ
    std::string worst;      ///< where the greatest difference in time is
};
Differences compare(const PulseMap& reference, const PulseMap& fast, const SensorNoise& noise,
                    double period_ns);

/// The bounds that fast_spacetime.h states.
void expect_equal(const Differences& found);

}  // namespace stria::test

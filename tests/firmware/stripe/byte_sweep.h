#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/stripe/spacetime.h"

namespace stria::test {

/// A small sweep of 8-bit frames and the options to analyse it with, decoded from any bytes: what
/// the fuzzer mutates and the property test draws. Header (missing bytes are zeros), then eight
/// bytes a pixel, then single samples:
///   options  min_snr 3..12, min_amplitude_dn 0..8, max_pulses_per_cell, max_pulse_frames 4..103,
///            history_frames 4..33, max_misfit 0.05..0.5
///   sensor   gain_e_per_dn 1..200 (from 196: no shot noise), black_dn 0..20, read noise 0..12 DN
///   frames   width 1..70, height 1..3, number 1..120, jitter 0..0.45 periods, exposure 0.001..1
///            periods, seed of the jitter
///   faults   share of frames dropped 0..0.1, repeated 0..0.1, late (a time stamp of the past)
///            0..0.05
///   light    ambient flicker 0..0.5 of the background, its period 1.5..20 frames
///   a pixel  background 0..120 DN, height 0..300 DN (clipped at 255), width 0.3..8 periods, place,
///            second pulse's share of the height and distance 0..20 periods, noise 0..12 DN (255:
///            what the sensor's parameters say), seed of the noise
struct ByteSweep {
    SpacetimeOptions options;
    SensorNoise noise;
    std::vector<Frame> frames;
    double period_ns = 1e6;
};
ByteSweep sweep_from_bytes(const std::uint8_t* data, std::size_t size);

/// Bytes of a sweep of random length, the same for the same seed.
std::vector<std::uint8_t> random_sweep_bytes(std::uint64_t seed);

/// A bound of firmware/stripe/README.md ("Fast") that a cell breaks.
struct Disagreement {
    std::string what;
    int x = 0, y = 0;
    Pulse reference, fast;  ///< of all zeros where there is none
};
std::string text_of(const Disagreement& of);

/// Analyses the sweep by the reference and by the fast analysis, on the best and on the plainest
/// instruction set, and says what breaks a bound. `pulses`, if given, grows by those compared.
std::vector<Disagreement> disagreements(const ByteSweep& sweep, std::size_t* pulses = nullptr);

}  // namespace stria::test

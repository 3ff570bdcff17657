#pragma once
#include <cstddef>
#include <optional>
#include <span>

#include "firmware/core/pulse.h"
#include "firmware/core/sensor_noise.h"

namespace stria {

/// Standard deviations of their difference by which two pulses of one place may differ: of Gaussian
/// noise one pair in a million is taken for two (chi-square of one degree of freedom, 24).
constexpr double kSamePlace = 4.9;

/// What a comparison needs to know of the sweep.
struct DirectionOptions {
    double from = 0, to = 0;  ///< positions that every pass went through, whole
    SensorNoise noise;
    /// A pulse must have been seen by the other direction if it is this many times higher than the
    /// least that an analyser claims (SpacetimeOptions::min_snr, min_amplitude_dn).
    double min_snr = 12;
    double min_amplitude_dn = 6;
};

/// What two directions of a sweep say of each other's pulses. A pulse is compared where it carries
/// no warning of its own.
struct DirectionComparison {
    std::size_t agreeing = 0;   ///< pulses that the opposite direction has as well
    std::size_t unseen = 0;     ///< flagged: it must have seen them, and holds nothing there
    std::size_t displaced = 0;  ///< flagged: its pulse stands elsewhere, beyond kSamePlace
    std::size_t beside = 0;  ///< flagged: nothing follows, but in its pixel another one is denied
    std::size_t untold = 0;  ///< nothing follows: weak, at an end, beside pulses with warnings
    /// Standard deviation of s that the passes show besides their pulses' own: of the axis log, of
    /// a mirror that trembles.
    double axis_sigma_s = 0;

    std::size_t flagged() const { return unseen + displaced + beside; }
};

/// Compares the passes of a swept spacetime sweep that went opposite ways with one laser and one
/// exposure, pixel by pixel, and flags kPulseGhostSuspected what cannot be a still surface lit by
/// the sheet: a pulse that no pass of the other direction has within kSamePlace standard deviations
/// (the pulses' own and axis_sigma_s), although one must have seen it. That one
/// - went through it, 3 of its widths to either side, and holds pulses nearby if it lost frames;
/// - would have shown it as high, min_snr times its noise and min_amplitude_dn;
/// - holds nothing within 3 widths that carries a warning (two pulses that run together may be one
///   on the way back), and no more than one other pulse that is not weaker by a fifth (an analyser
///   keeps the strongest).
/// In a pixel where one pulse is denied those that nothing confirms are flagged with it.
/// Suspicions by strength alone, the analyser's, are taken back first. Of still surfaces two
/// pulses in a million are flagged, if noise is Gaussian. A ghost of still surfaces agrees with
/// itself: it is not told.
/// Needs s and ds_dt, the clock delay taken out. Empty, and nothing touched, where no pixels (100
/// or more) hold a pulse of either direction to measure axis_sigma_s by.
std::optional<DirectionComparison> compare_directions(std::span<PulseMap> passes,
                                                      const DirectionOptions& options);

/// Standard deviation of s from the fit of a pulse in time.
double sigma_of_s(const Pulse& pulse);
/// The one unflagged pulse of a cell, if there is one, with a sigma.
const Pulse* clean_pulse(const PulseMap& map, std::size_t cell);
/// Whether they are of one pixel and laser.
bool same_pixel(const Pulse& a, const Pulse& b);

}  // namespace stria

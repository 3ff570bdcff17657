#pragma once
#include <optional>
#include <span>

#include "firmware/core/pulse.h"

namespace stria {

/// How much later than its stamps the axis log is right, from passes in two directions: a pulse is
/// then early in one of them and late in the other.
struct ClockDelay {
    double delay_ns = 0;  ///< true time = stamp + delay
    /// Standard deviation, from the scatter of the cells; for peaks from that of whole frames,
    /// which share what the axis trembles by. For pulses in time that is left out: compare sweeps,
    /// mean_of().
    double sigma_ns = 0;
    std::size_t cells = 0;  ///< places compared
};

/// Delay that is left in the positions s of passes over the same grid; empty with passes of one
/// direction, or where fewer than 100 places tell.
/// Pulses in time: the median over the cells that hold one unflagged pulse in a pass of each
/// direction. Peaks in a row: the stripe's column in a row is one function of the true position
/// whichever way the axis goes, so both directions' columns are laid over each other (least sum of
/// absolute differences by columns that a parabola through the neighbouring frames of the other
/// direction gives); a flat scene, whose stripe stays where it is, tells nothing.
std::optional<ClockDelay> clock_delay(std::span<const PulseMap> passes);

/// The mean of several (at least one), each weighing 1 / sigma^2; its sigma by theirs, or by their
/// scatter where that is more.
ClockDelay mean_of(std::span<const ClockDelay> delays);

/// Moves every s by what a further delay makes of it, to first order: s += ds/dt x delay.
void apply_delay(PulseMap& map, double delay_ns);

}  // namespace stria

#include "firmware/core/pulse.h"

#include <cmath>

#include "firmware/core/frame.h"

namespace stria {
namespace {

bool is_finite(const Pulse& p) {
    return std::isfinite(p.u) && std::isfinite(p.v) && std::isfinite(p.s) &&
           std::isfinite(p.ds_dt) && std::isfinite(p.amplitude) && std::isfinite(p.width) &&
           std::isfinite(p.background) && std::isfinite(p.sigma) && std::isfinite(p.chi_square);
}

}  // namespace

bool is_valid(const PulseMap& map) {
    if (map.width < 0 || map.height < 0 || map.height > kMaxFrameSide) return false;
    const std::size_t cells =
        static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height);
    if (map.cell_begin.size() != cells + 1 || map.cell_begin.front() != 0 ||
        map.cell_begin.back() != map.pulses.size())
        return false;
    for (std::size_t i = 0; i < cells; ++i) {
        if (map.cell_begin[i + 1] < map.cell_begin[i]) return false;
        if (map.cell_begin[i + 1] - map.cell_begin[i] > kMaxPulsesPerCell) return false;
    }
    for (const Pulse& pulse : map.pulses)
        if (!is_finite(pulse)) return false;
    return true;
}

namespace {

/// Mean speed while the pulse lasted, where the log holds both its sides: a single segment's slope
/// has the noise of its two ends.
double speed_during(const AxisLog& log, TimeNs time_ns, const Pulse& pulse, double otherwise) {
    const TimeNs half_ns = std::llround(pulse.width);
    const auto before = position_at(log, time_ns - half_ns);
    const auto after = position_at(log, time_ns + half_ns);
    if (half_ns < 1 || !before || !after) return otherwise;
    return (after->s - before->s) / (2e-9 * static_cast<double>(half_ns));
}

}  // namespace

std::size_t assign_axis_positions(PulseMap& map, const AxisLog& log, double delay_ns) {
    std::vector<Pulse> kept;
    kept.reserve(map.pulses.size());
    const std::size_t before = map.pulses.size();
    std::uint32_t begin = 0;
    for (std::size_t i = 0; i + 1 < map.cell_begin.size(); ++i) {
        const std::uint32_t end = map.cell_begin[i + 1];
        map.cell_begin[i] = static_cast<std::uint32_t>(kept.size());
        for (std::uint32_t k = begin; k < end; ++k) {
            Pulse pulse = map.pulses[k];
            const TimeNs time_ns = pulse.t_ns + std::llround(delay_ns);
            const auto state = position_at(log, time_ns);
            if (!state) continue;
            const bool in_time = map.mode == StripeMode::spacetime &&
                                 (pulse.flags & kPulseSpatialFallback) == 0;  // width is ns
            pulse.s = state->s;
            pulse.ds_dt = in_time ? speed_during(log, time_ns, pulse, state->ds_dt) : state->ds_dt;
            kept.push_back(pulse);
        }
        begin = end;
    }
    if (!map.cell_begin.empty()) map.cell_begin.back() = static_cast<std::uint32_t>(kept.size());
    map.pulses = std::move(kept);
    return before - map.pulses.size();
}

}  // namespace stria

#pragma once
#include <cmath>
#include <cstdint>
#include <vector>

#include "firmware/core/pulse.h"

/// Small maps of pulses, cell by cell.
namespace stria::test_maps {

inline constexpr double kRate = 0.5;  // rad/s
inline constexpr int kSide = 40;

inline Pulse pulse_at(int x, int y, double s, double sigma_s, double rate = kRate) {
    Pulse pulse;
    pulse.u = static_cast<float>(x);
    pulse.v = static_cast<float>(y);
    pulse.s = s;
    pulse.ds_dt = rate;
    pulse.sigma = static_cast<float>(sigma_s / std::abs(rate) * 1e9);
    pulse.amplitude = 100;
    return pulse;
}

/// A map of kSide x kSide cells from `of_cell(x, y)`, which gives the pulses of a cell.
template <typename OfCell>
PulseMap map_of(OfCell of_cell) {
    PulseMap map;
    map.width = map.height = kSide;
    map.frames = 10;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
            for (const Pulse& pulse : of_cell(x, y)) map.pulses.push_back(pulse);
        }
    map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
    return map;
}

}  // namespace stria::test_maps

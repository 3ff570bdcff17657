#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/core/axis_log.h"
#include "firmware/core/time.h"

namespace stria {

/// What is known about a pulse beyond its numbers; decimal sums in files.
enum PulseFlag : std::uint16_t {
    kPulseSaturated = 1,
    kPulseSpatialFallback = 2,  ///< along paths: width and sigma are px, as of a spatial peak
    kPulseOverlapping = 4,
    kPulseGhostSuspected = 8,
    kPulseWidthOutOfRange = 16,
    kPulseTouchesSequenceEnd = 32,  ///< first or last frame
    kPulseImageBorder = 64,
};

/// How the stripe was found; decides the unit of a pulse's width and sigma.
enum class StripeMode : std::uint8_t {
    spatial = 0,    ///< peak in an image row: width and sigma in px, across u
    spacetime = 1,  ///< pulse in time: width and sigma in ns
};

/// One crossing of the stripe over one surface point.
struct Pulse {
    float u = 0, v = 0;    ///< pixel, (0, 0) the centre of the top-left one
    TimeNs t_ns = 0;       ///< device clock
    double s = 0;          ///< axis position at t_ns
    double ds_dt = 0;      ///< per second
    float amplitude = 0;   ///< DN above background
    float width = 0;       ///< Gaussian standard deviation, ns or px by the map's mode
    float background = 0;  ///< DN
    float sigma = 0;       ///< standard deviation of t_ns (ns) or of u (px), from the fit
    float chi_square = 0;  ///< per degree of freedom
    std::uint16_t flags = 0;
    std::uint8_t laser_id = 0;
    std::uint8_t exposure_index = 0;
};

constexpr int kMaxPulsesPerCell = 4;

/// The pulses of a sweep on their grid, cell by cell, row-major, strongest first within a cell.
/// Swept spacetime: the grid is the image (cell = pixel). Spatial, and spacetime along paths:
/// width = frames k, height = image rows v.
struct PulseMap {
    StripeMode mode = StripeMode::spacetime;
    int width = 0;
    int height = 0;
    std::uint8_t camera_id = 0;
    std::vector<std::uint32_t> cell_begin;  ///< width x height + 1 offsets into pulses
    std::vector<Pulse> pulses;
    std::uint32_t frames = 0;          ///< analysed
    std::uint32_t frames_dropped = 0;  ///< gaps in the sequence
    std::uint32_t saturated_samples = 0;
    bool undersampled = false;  ///< the step exceeds the stripe's width: no pulses claimed

    std::span<const Pulse> cell(int x, int y) const {
        const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                              static_cast<std::size_t>(x);
        return {pulses.data() + cell_begin[i], pulses.data() + cell_begin[i + 1]};
    }
};

/// True if the offsets ascend from 0 to pulses.size(), no cell holds more than
/// kMaxPulsesPerCell, sizes are within kMaxFrameSide and every number is finite.
bool is_valid(const PulseMap& map);

/// Writes s and ds_dt of every pulse from the log, read at t_ns + delay_ns (true time = stamp +
/// delay). ds_dt of a pulse in time is the mean over a standard deviation on either side of it.
/// Pulses outside the log's span are removed; returns how many.
std::size_t assign_axis_positions(PulseMap& map, const AxisLog& log, double delay_ns = 0);

}  // namespace stria

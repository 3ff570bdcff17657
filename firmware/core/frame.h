#pragma once
#include <cstdint>
#include <vector>

#include "firmware/core/image_view.h"
#include "firmware/core/time.h"

namespace stria {

constexpr int kMaxFrameSide = 16384;  ///< px; larger claims are refused before memory is taken

/// One mono image of a camera, with everything that later steps need to know about its moment.
/// Samples of 8 bits take one byte each, of 9 to 16 bits two bytes, native (little) endian.
struct Frame {
    std::vector<std::uint8_t> bytes;  ///< width x height samples, row-major, rows not padded
    int width = 0;
    int height = 0;
    int bits = 8;  ///< 8..16; full scale is 2^bits - 1
    std::uint8_t camera_id = 0;
    std::uint8_t laser_id = 0;        ///< whose stripe; meaningless where laser_power is 0
    std::uint8_t exposure_index = 0;  ///< which of the plan's exposures
    float laser_power = 0;            ///< 0 (off) to 1
    TimeNs exposure_start_ns = 0;     ///< of row 0
    TimeNs exposure_ns = 0;
    TimeNs row_time_ns = 0;      ///< from one row's exposure to the next's; 0: global shutter
    std::uint32_t sequence = 0;  ///< counts the camera's frames; a gap is a lost frame

    int bytes_per_sample() const { return bits > 8 ? 2 : 1; }
    int full_scale() const { return (1 << bits) - 1; }
    /// Pixels of a frame of 8 bits / of 9 to 16 bits.
    ImageView<const std::uint8_t> view8() const { return {bytes.data(), width, height, width}; }
    ImageView<const std::uint16_t> view16() const {
        return {reinterpret_cast<const std::uint16_t*>(bytes.data()), width, height, width};
    }
    int sample(int x, int y) const { return bits > 8 ? view16().at(x, y) : view8().at(x, y); }
    /// Middle of a row's exposure: exposure start + half the exposure + row x row time.
    TimeNs row_time(int y) const { return exposure_start_ns + exposure_ns / 2 + y * row_time_ns; }
};

/// Sizes `frame` for width x height samples of `bits`; keeps the memory where it suffices.
void resize(Frame& frame, int width, int height, int bits);

}  // namespace stria

#pragma once
#include <string>

#include "host/core/range_image.h"

namespace stria {

/// Reads a range PLY: the Stanford layout (element range_grid with lists of 0 or 1 index, obj_info
/// num_cols and num_rows) and what stria adds to it (see write_range_image). Missing sigmas are 0.
/// @param mm_per_unit  positions, stations and sigmas are multiplied by it
RangeImage read_range_image(const std::string& path, double mm_per_unit = 1.0);

/// True if the PLY has a range grid; false for other readable PLYs.
bool has_range_grid(const std::string& path);

/// Writes the range PLY of FORMATS: vertices float x y z nx ny nz intensity sigma sigma_across
/// sigma_systematic ex ey ez s, uchar return_index, ushort flags; range_grid; station. Binary
/// little endian, whole or not at all.
void write_range_image(const std::string& path, const RangeImage& image);

}  // namespace stria

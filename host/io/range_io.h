#pragma once
#include <string>
#include <string_view>

#include "host/core/range_image.h"

namespace stria {

/// Reads a range PLY: the Stanford layout (element range_grid with lists of 0 or 1 index, obj_info
/// num_cols and num_rows) and what stria adds to it (see write_range_image). Missing sigmas are 0.
/// Vertices with a return_index above 0 are further returns of the cell whose vertex stands last
/// before them; other vertices outside the grid are left out. Throws FileError, also for points in
/// the grid that are not finite.
/// @param mm_per_unit  positions, stations, sigmas and sensitivities are multiplied by it
RangeImage read_range_image(const std::string& path, double mm_per_unit = 1.0);
/// The same from memory; `name` stands for the path in errors.
RangeImage parse_range_image(std::string_view bytes, const std::string& name,
                             double mm_per_unit = 1.0);

/// True if the PLY has a range grid; false for other readable PLYs.
bool has_range_grid(const std::string& path);

/// Writes a range PLY: vertices float x y z nx ny nz intensity sigma sigma_across sigma_systematic
/// ex ey ez s, then sensitivity_0 .. where the image has sensitivities, uchar return_index, ushort
/// flags, each cell's further returns right after its point; range_grid; station, double. Binary
/// little endian, whole or not at all.
/// Throws std::invalid_argument for a further return of an empty cell.
void write_range_image(const std::string& path, const RangeImage& image);
std::string format_range_image(const RangeImage& image);

}  // namespace stria

#pragma once
#include "firmware/core/image_paths.h"
#include "host/core/scanner_model.h"

namespace stria {

/// Image paths of a rail or turntable channel. Both move the part by the same step whatever s is,
/// so the path of the point where a pixel's ray meets the sheet is a function of the pixel alone; a
/// parabola through its images one and a half widths before and after, which over three widths
/// keeps within 0.02 px of the exact path on the scanners in examples/scenes. Throws stria::Error
/// for a swept machine, whose pixels are surface points.
/// @param model_hash  of the model that the channel belongs to
/// @param nodes       along each side
PathTable make_path_table(const Channel& channel, const std::string& model_hash, int nodes = 65);

}  // namespace stria

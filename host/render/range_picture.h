#pragma once
#include <vector>

#include "firmware/core/frame.h"
#include "host/core/image.h"
#include "host/core/range_image.h"
#include "host/render/colour_map.h"

namespace stria {

/// A value a cell in the scale's colours; cells with mask 0 are white. `values` and `mask` are
/// width x height, row-major. Reduced by whole factors until it is at most max_side wide and high.
ColourImage picture_of_values(int width, int height, const std::vector<float>& values,
                              const std::vector<std::uint8_t>& mask, const ColourScale& scale,
                              int max_side = 640);

/// Distance along the scan frame's z of a range image, shaded by its slope, with the scale used.
struct RangePicture {
    ColourImage picture;
    ColourScale scale;
};
RangePicture picture_of_range(const RangeImage& image, int max_side = 640);

/// A camera frame as grey, with full scale white; `gain` brightens dark ones.
ColourImage picture_of_frame(const Frame& frame, double gain = 1.0, int max_side = 4096);

}  // namespace stria

#pragma once
#include "firmware/core/frame.h"
#include "host/core/image.h"

namespace stria {

/// A photograph as a camera's frame, so that stripe analysis takes it: its samples as they are, of
/// `bits` (8 to 16), laser on, one exposure at time 0, global shutter. Set sequence and
/// exposure_start_ns for a series.
Frame frame_from_image(const Grey16Image& image, int bits);

/// The frame's samples.
Grey16Image image_from_frame(const Frame& frame);

/// The frame mirrored at its diagonal: columns become rows, for stripes that run along the rows.
/// Row times are those of the first row; only global shutters keep their meaning.
Frame transposed(const Frame& frame);

}  // namespace stria

#pragma once
#include "host/core/range_image.h"
#include "host/core/scanner_model.h"

namespace stria {

/// Motion from the scan frame into a line profiler's: X along the stripe, Y travel, Z height (away
/// from the surface, towards the laser), origin that of the scan frame. Rail: Y is the travel of
/// the head; swept: the way the stripe moves over a plane facing the laser in mid-sweep. Throws
/// stria::Error for a turntable, which has no direction of travel.
Rigid3 profiler_from_scan(const Channel& channel, double middle_s);

/// The image with every point, direction, normal and station moved.
RangeImage moved(const RangeImage& image, const Rigid3& motion);

}  // namespace stria

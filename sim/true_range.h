#pragma once
#include <span>

#include "host/core/range_image.h"
#include "sim/scene.h"
#include "sim/scene_geometry.h"

namespace stria {

/// See SimulatedScanner::true_range.
RangeImage true_range_swept(const Scene& scene, const SceneGeometry& geometry);
RangeImage true_range_of_frames(const Scene& scene, const SceneGeometry& geometry,
                                std::span<const double> frame_s);

}  // namespace stria

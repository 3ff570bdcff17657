#pragma once
#include <string>

#include "host/core/rigid3.h"

namespace stria {

/// Where a scan stands in the world.
struct ScanPose {
    std::string file;  ///< the scan it belongs to, as poses.toml names it
    Rigid3 world_from_scan;
    Matrix6d covariance = Matrix6d::Zero();  ///< order rx ry rz tx ty tz; zero: unknown
    bool fixed = false;                      ///< registration must not move it
};

}  // namespace stria

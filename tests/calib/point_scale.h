#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "calib/predicted_sigma.h"
#include "host/core/scanner_model.h"

namespace stria {

/// Similarity's scale from the points of one laser, found to true.
inline double scale_of(const ScannerModel& truth, const ScannerModel& found,
                       const std::vector<VolumeSample>& samples, std::size_t channel) {
    Eigen::Matrix3Xd right(3, 0), ours(3, 0);
    for (const VolumeSample& sample : samples) {
        if (sample.channel != channel) continue;
        const auto a = triangulate(truth.channels[channel], sample.pixel, sample.s);
        const auto b = triangulate(found.channels[channel], sample.pixel, sample.s);
        if (!a || !b) continue;
        right.conservativeResize(3, right.cols() + 1);
        ours.conservativeResize(3, ours.cols() + 1);
        right.rightCols<1>() = a->point_in_scan;
        ours.rightCols<1>() = b->point_in_scan;
    }
    return std::cbrt(Eigen::umeyama(ours, right).topLeftCorner<3, 3>().determinant());
}

}  // namespace stria

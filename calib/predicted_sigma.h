#pragma once
#include <Eigen/Core>
#include <vector>

#include "calib/scanner_calibration.h"

namespace stria {

/// A triangulated spot of the volume: pixel and axis position.
struct VolumeSample {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    double s = 0;
};

/// Standard deviation of the points of a model's first channel that its covariance predicts, over
/// the samples given, after the rigid motion common to all of them is taken out (first order).
/// Samples that do not triangulate are left out. Zero without covariance or with fewer than 4
/// samples.
PredictedSigma predict_sigma(const ScannerModel& model, const std::vector<VolumeSample>& samples);

}  // namespace stria

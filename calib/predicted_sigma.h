#pragma once
#include <Eigen/Core>
#include <vector>

#include "calib/scanner_calibration.h"

namespace stria {

/// A triangulated spot of the volume: pixel and axis position.
struct VolumeSample {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    double s = 0;
    std::size_t channel = 0;
};

/// Covariance of every sample's point (3 x 3, mm^2, scan frame) that the model's covariance
/// predicts, after the rigid motion common to all of them is taken out (first order). Zero for
/// samples that do not triangulate; empty without covariance or with fewer than 4 samples.
std::vector<Eigen::Matrix3d> predict_covariance(const ScannerModel& model,
                                                const std::vector<VolumeSample>& samples);

/// The same as standard deviations over all samples that triangulate. Zero without covariance or
/// with fewer than 4 samples.
PredictedSigma predict_sigma(const ScannerModel& model, const std::vector<VolumeSample>& samples);

}  // namespace stria

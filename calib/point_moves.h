#pragma once
#include <Eigen/Core>
#include <vector>

#include "calib/predicted_sigma.h"

namespace stria {

/// Samples of the first channel's field that lie between two distances from the camera: an even
/// lattice of pixels, each at every one of `positions` axis positions of the sweep that puts the
/// point there.
std::vector<VolumeSample> field_samples(const Channel& channel, double from, double to,
                                        double near_mm, double far_mm, int positions = 15);

/// Distances (0.8 and 1.25 of it) round where the sheet in the middle of the sweep meets the
/// camera's axis; {0, 0} where it does not.
Eigen::Vector2d working_distance_mm(const Channel& channel, double from, double to);

/// Takes out of stacked displacements (3 rows a point, any number of columns) the rigid motion
/// common to all points, in first order.
void remove_rigid_motion(const std::vector<Eigen::Vector3d>& points, Eigen::MatrixXd& moves);

/// How the samples' points (scan frame, 3 rows each) move with each mode of the model (columns of
/// one standard deviation, see covariance_modes()), the rigid motion common to all taken out.
/// Samples that do not triangulate have zero rows.
Eigen::MatrixXd point_moves(const ScannerModel& model, const Eigen::MatrixXd& modes,
                            const std::vector<VolumeSample>& samples);

/// Where both models triangulate: by how much b's points differ from a's after the best rigid
/// motion (first order); 3 rows each, zero where one does not.
Eigen::VectorXd point_differences(const ScannerModel& a, const ScannerModel& b,
                                  const std::vector<VolumeSample>& samples);

}  // namespace stria

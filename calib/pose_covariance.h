#pragma once
#include "calib/camera_calibration.h"
#include "host/core/rigid3.h"

namespace stria {

/// Covariance of a board's pose (rx ry rz tx ty tz of delta in true = exp(delta) * estimate; rad,
/// mm) for corners with a standard deviation of 1 px a coordinate, camera and board exact. At least
/// 4 points that are not on one line (std::invalid_argument otherwise).
Matrix6d pose_covariance(const CameraModel& camera, const Rigid3& camera_from_board,
                         const CameraView& view, const Board& board);

}  // namespace stria

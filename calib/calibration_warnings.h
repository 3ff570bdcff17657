#pragma once
#include <string>
#include <vector>

#include "calib/scanner_calibration.h"

namespace stria {

/// Points that the warnings judge by.
struct CalibrationCoverage {
    std::vector<Eigen::Vector3d> board_normals;  ///< of the used views, camera frame, s = 0
    std::vector<Eigen::Vector2d> corner_pixels;
    std::vector<Eigen::Vector3d> stripe_in_camera;  ///< stripe points on the boards
    std::vector<double> picture_s;                  ///< axis positions of pictures used
};

/// What is weak about a finished calibration and what would help: boards nearly parallel, thin
/// depth range, part of the image never covered, stripes of a fixed sheet all on one line, small
/// arc or travel of the axis, focal length loose, stripe sigmas that do not hold, predicted point
/// error above 1e-4 of the volume's diagonal (naming the weakest parameter).
std::vector<std::string> calibration_warnings(const ScannerCalibration& result,
                                              const CalibrationCoverage& coverage);

}  // namespace stria

#pragma once
#include "calib/camera_problem.h"

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

/// Sets camera and poses of the problem to a start from which the full solve converges: of the
/// candidate focal lengths (options.start, Zhang's, 0.3 to 4 image widths) the one that explains
/// the views best after a short robust solve over focal length and k1. Views without a pose are
/// rejected with the reason.
void choose_start(CameraProblem& problem, const Board& board, int width, int height,
                  const CameraCalibrationOptions& options);

}  // namespace stria

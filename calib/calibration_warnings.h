#pragma once
#include <string>
#include <vector>

#include "calib/degeneracies.h"
#include "calib/scanner_calibration.h"

namespace stria {

/// What is weak about a finished calibration and what would help: what judge_coverage() finds,
/// focal length loose, axis left at its drawing, stripe sigmas that do not hold, predicted point
/// error above 1e-4 of the volume's diagonal (naming the weakest parameter).
std::vector<std::string> calibration_warnings(const ScannerCalibration& result,
                                              const CalibrationCoverage& coverage);

}  // namespace stria

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

/// What to say of a mirror that came out `most_rad` or more from its drawing, where the solver's
/// border is near: a false solution, or not the drawn machine. Empty for less, and for other axes.
std::string far_from_drawing(const AxisModel& solved, const AxisModel& drawn, double most_rad);

/// What to say of two tilts of the mirror whose half chi-squares are `margin` apart, of which a
/// covariance knows one. Empty where the data tell them apart by 2 sigma.
std::string alike_mirrors(double margin);

}  // namespace stria

#pragma once
#include <vector>

#include "calib/scanner_problem.h"

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

/// Fills in what a solved problem says: model with covariance, volume and rms, sigmas, views,
/// predicted sigma, and warnings of what is weak.
/// @param noise   how corners err; if they do not independently, the covariance is the sandwich of
///                shared_covariance(): the solve took them as independent
/// @param source  of each view of the problem, index into result.views
void summarise(ScannerProblem& problem, const std::vector<std::size_t>& source,
               const ScannerModel& nominal, const Board& board, const CornerNoise& noise,
               ScannerCalibration& result);

}  // namespace stria

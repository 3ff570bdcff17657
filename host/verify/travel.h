#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/verify/artefact.h"
#include "host/verify/flatness.h"

namespace stria {

/// A flat target where it stood in one scan.
struct TravelStep {
    double true_mm = 0;         ///< along the travel, as the artefact file states it
    double measured_mm = 0;     ///< likewise, mean difference from true_mm over all steps taken out
    double error_mm = 0;        ///< measured_mm - true_mm
    double point_sigma_mm = 0;  ///< of single points about their plane: what one point repeats
    double plane_sigma_mm = 0;  ///< of measured_mm, from point_sigma_mm, points as independent
};

/// Linearity and repeatability over the measuring range, as makers of profile sensors state them.
struct TravelFigures {
    std::vector<TravelStep> steps;  ///< in the order of the scans
    double linearity_mm = 0;      ///< greatest |mean error of a place|, offset taken out, scale not
    double range_mm = 0;          ///< between the nearest and the farthest place
    double scale_error = 0;       ///< slope of the errors over the travel, mm a mm
    double repeatability_mm = 0;  ///< standard deviation of the planes at one place, pooled over
                                  ///< the places that were scanned again; NaN: none was
    std::size_t repeats = 0;      ///< degrees of freedom of repeatability_mm
};

/// Figures of a flat target that travels along its normal between scans. The scanner's frame stays;
/// a target that travels at an angle to its normal would be measured short by the cosine.
/// Throws stria::Error for fewer than three places, and for a target that tilts by more than 2 deg
/// between scans.
/// @param travelled  of each plane, mm; equal numbers are repeats of one place
TravelFigures travel_figures(const std::vector<MeasuredPlane>& planes,
                             const std::vector<double>& travelled);

}  // namespace stria

#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/verify/scan_points.h"

namespace stria {

/// Of how many measured points the procedures allow to reject: three in a thousand.
std::size_t most_rejected(std::size_t count);

/// 1 for each residual that stays when the `rejected` farthest from zero go; of equal ones the
/// later index goes first.
std::vector<std::uint8_t> keep_mask(const std::vector<double>& residuals, std::size_t rejected);

/// How a surface's points lie about the fitted shape.
struct FormFigures {
    std::size_t points_used = 0;  ///< those that the figures are of
    std::size_t rejected = 0;
    double form_mm = 0;      ///< greatest minus least residual of the points used
    double form_all_mm = 0;  ///< the same without rejection
    double d95_mm = 0;    ///< least width of a shell that holds 95 % of all points, rejected or not
    double sigma_mm = 0;  ///< standard deviation of the points used

    /// From the scan's own sigmas; NaN where the scan states none.
    double predicted_sigma_mm = 0;  ///< random, along the surface's normal, rms over the points
    double predicted_systematic_mm = 0;  ///< what calibration shares; the fit takes most of it away
    double expected_form_mm = 0;         ///< form_mm that random noise alone would show
    double sigma_ratio = 0;              ///< 1.4826 MAD of residual / predicted sigma, all points
    double form_ratio = 0;               ///< form_mm / predicted_sigma_mm

    /// Of all measured points in their order, mm, positive outside; the fit is that of those kept.
    std::vector<double> residuals_mm;
    std::vector<std::uint8_t> kept;
    std::vector<double> point_sigmas_mm;  ///< predicted, along the normal; empty where not known
};

/// The figures of residuals about a fit with `parameters` free numbers, of which `kept` were used.
/// @param normals  of the fitted shape at the points, unit, outwards
FormFigures form_figures(std::vector<double> residuals_mm, std::vector<std::uint8_t> kept,
                         int parameters, const ScanPoints& points,
                         const std::vector<Eigen::Vector3d>& normals);

}  // namespace stria

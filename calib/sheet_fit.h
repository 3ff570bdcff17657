#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

namespace stria {

/// A line that must lie in the sheet, by its two ends (mm, camera frame).
struct SheetLine {
    std::array<Eigen::Vector3d, 2> ends;
    /// Of the ends' distances from the sheet (mm^2), for a sheet with that normal.
    Eigen::Matrix2d covariance_along(const Eigen::Vector3d& sheet_normal) const;

    Eigen::Vector3d across;                       ///< unit, across the line in the board's plane
    Eigen::Matrix2d line_covariance;              ///< of the ends along `across`, mm^2
    Eigen::Matrix<double, 6, 6> pose_covariance;  ///< of the board, as Rigid3 has it
};

struct SheetFit {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< unit; offset_mm > 0
    double offset_mm = 0;                               ///< normal . p = offset_mm
    /// Of (normal, offset_mm): rank 3, a unit normal moves across itself alone.
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
    double chi_square = 0;   ///< per degree of freedom of the used lines; above 1 it has raised
                             ///< the covariance; 0 where two lines leave 1 degree or none
    std::vector<bool> used;  ///< of each line
};

/// Plane through lines, each weighted by its covariance. Start: the plane through two lines that
/// the median line lies nearest to; then Huber's least squares, plain at the end without lines
/// farther than 5 robust standard deviations from it (`reject_lines`, from 4 lines on). At least 2
/// lines (std::invalid_argument otherwise). What the lines leave open shows in the covariance.
SheetFit fit_sheet(const std::vector<SheetLine>& lines, bool reject_lines = true);

/// Spread (mm, rms) of the lines within their common plane, across their mean direction: near 0
/// where all lie on one line, about which the sheet can turn.
double spread_across_mm(const std::vector<SheetLine>& lines);

}  // namespace stria

#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/camera_calibration.h"
#include "calib/stripe_line.h"
#include "host/core/board.h"
#include "host/core/camera_model.h"

namespace stria {

/// One placement of the board: its corners, and the stripe over it.
struct SheetView {
    CameraView corners;
    /// Of the whole picture, as found along its rows, along its columns, or both: what gives more
    /// points on the board counts.
    std::vector<std::vector<StripePeak>> peaks;
};

struct SheetViewResult {
    std::string name;
    std::string rejected;                 ///< why the view was not used; empty if it was
    int points = 0;                       ///< stripe points on the board
    std::vector<Eigen::Vector2d> pixels;  ///< where those are in the picture
    double rms_mm = 0;                    ///< of them from the sheet
    double left_out_rms_mm = 0;  ///< of them from the sheet of all other views; 0: fewer than 3
};

struct SheetCalibration {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();  ///< camera frame, unit
    double offset_mm = 0;                               ///< normal . p = offset_mm > 0
    /// Of (normal, offset_mm); camera and board taken as exact.
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
    double turn_sigma_rad = 0;   ///< standard deviation of the normal in its loosest direction
    double rms_mm = 0;           ///< of the stripe points used from the sheet
    double left_out_rms_mm = 0;  ///< the same, each view against the sheet of the others
    double chi_square = 0;       ///< per degree of freedom of the lines; above 1: raised covariance
    double corner_sigma_px = 0;  ///< standard deviation of a corner's coordinate, from all views
    int points_used = 0;
    int views_used = 0;
    std::vector<SheetViewResult> views;  ///< in the order given
};

/// A flat sheet of light from a stripe over a board in several placements: each board's pose from
/// its corners, the stripe as a straight line on it (stripe_line_on_board), then the plane through
/// the lines, weighted by what peaks and corners leave open, robust first and plain least squares
/// at the end (fit_sheet). Views without board pose or stripe, or whose line lies off the sheet of
/// the others, are rejected with the reason. Throws stria::Error, saying what to do: a camera that
/// is not valid, fewer than 2 usable views, stripes that all lie on one line (the sheet can turn
/// about it), a sheet through the camera's centre (it triangulates nothing). Deterministic.
SheetCalibration calibrate_sheet(const std::vector<SheetView>& views, const Board& board,
                                 const CameraModel& camera);

}  // namespace stria

#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "calib/corner_noise.h"
#include "host/core/board.h"
#include "host/core/camera_model.h"
#include "host/core/rigid3.h"

namespace stria {

/// Points of a board seen in one picture of the camera.
struct CameraView {
    std::string name;                     ///< file or number, for people
    std::vector<int> ids;                 ///< into board_points()
    std::vector<Eigen::Vector2d> pixels;  ///< same order
    std::vector<double> weights;          ///< multiply the residuals; <= 0: left out; empty: all 1
};

struct CameraCalibrationOptions {
    LensKind lens = LensKind::brown5;  ///< right for most lenses below 90 deg of view
    /// Also solve how far the board bulges: z = warp_x (1 - gx^2) + warp_y (1 - gy^2), g running
    /// from -1 to 1 over the board's points. Off: printed boards on glass are flat to well below
    /// 0.1 mm.
    bool board_warp = false;
    /// Keep every corner and view that can be used at all, as OpenCV does.
    bool reject_outliers = true;
    /// Estimate how neighbouring corners err together; off: their errors count as independent.
    bool shared_errors = true;
    std::optional<CameraModel> start = {};  ///< a rough camera; empty: from the views alone
};

struct CameraViewResult {
    std::string name;
    std::string rejected;  ///< why the view was not used; empty if it was
    double rms_px = 0;     ///< of its used points
    int points_used = 0;
    std::vector<int> ids_rejected;  ///< points left out: weight <= 0, or far off all others
    Rigid3 camera_from_board;
};

struct CameraCalibration {
    CameraModel camera;
    double rms_px = 0;  ///< sqrt(sum of squared 2-D residuals / points)
    int points_used = 0;
    int views_used = 0;
    bool converged = false;
    int iterations = 0;      ///< of the last solve
    double sigma_pixel = 0;  ///< of one coordinate, px: residuals over the degrees of freedom
    CornerNoise noise;       ///< which of it neighbouring corners share
    /// Of fx fy cx cy and the lens kind's distortion, for corners that err like that; poses free.
    Eigen::MatrixXd covariance;
    Eigen::Vector2d board_warp_mm = Eigen::Vector2d::Zero();
    std::vector<CameraViewResult> views;  ///< in the order given
};

/// Camera from pictures of a flat board: focal length from homographies (Zhang 2000, with further
/// candidates for wide lenses), then our own least squares in stages (Huber first, plain at the
/// end) over intrinsics and poses; covariance from the final Jacobian. Points farther than 8 robust
/// standard deviations (and 1 px) from their place are left out and listed, views with a third of
/// such points rejected with the reason. Throws stria::Error if fewer than 3 views remain, or the
/// views cannot tell the focal length (all parallel). Deterministic.
CameraCalibration calibrate_camera(const std::vector<CameraView>& views, const Board& board,
                                   int width, int height,
                                   const CameraCalibrationOptions& options = {});

/// Residuals' root mean square of a camera and pose against one view (weights <= 0 left out).
double view_rms_px(const CameraModel& camera, const Rigid3& camera_from_board,
                   const CameraView& view, const Board& board);

/// Pose of the board from at least 4 points (planar PnP and refinement); empty if there is none.
std::optional<Rigid3> board_pose(const CameraModel& camera, const CameraView& view,
                                 const Board& board);

}  // namespace stria

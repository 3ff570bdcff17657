#pragma once
#include <ceres/ceres.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calib/camera_calibration.h"
#include "calib/camera_cost.h"
#include "calib/corner_noise.h"

/// For calib's own .cpp files only: it shows Ceres.
namespace stria {

/// One camera, one board, the poses of many views: parameters and the points in use.
class CameraProblem {
  public:
    CameraProblem(const std::vector<CameraView>& views, const Board& board);

    struct View {
        const CameraView* source = nullptr;
        Vector6d pose = Vector6d::Zero();
        bool used = false;
        std::string rejected;           ///< why not used
        std::vector<std::uint8_t> use;  ///< of each point
    };

    /// Poses of all views for that camera by PnP; views without one are not used.
    void find_poses(const CameraModel& start);

    struct Solve {
        std::vector<int> free;  ///< entries of the camera block that may move
        double huber_px = 0;    ///< 0: plain least squares
        bool board_warp = false;
        int max_iterations = 100;
    };
    /// Least squares over camera, used poses and warp. Returns Ceres' account.
    ceres::Solver::Summary solve(const Solve& how);

    /// Residual vectors (measured - predicted has the sign predicted - measured), used points only,
    /// by view; a point behind the camera counts as 1e6 px.
    std::vector<std::vector<double>> residual_lengths() const;

    /// Used corners of each used view, linearised where the parameters are. Shared columns: the
    /// free camera entries, then the warp if it is solved. Points behind the camera are left out.
    std::vector<CornerRows> corner_rows(const std::vector<int>& free, bool board_warp) const;

    std::array<double, kCameraSize> camera{};
    std::array<double, 2> warp{};  ///< that of the board to begin with
    std::vector<View> views;

  private:
    void build(ceres::Problem& problem, const Solve& how);
    std::vector<Eigen::Vector3d> points_;  ///< board points
    std::vector<Eigen::Vector2d> rises_;   ///< see BoardRise
    const Board& board_;
};

}  // namespace stria

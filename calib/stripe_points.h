#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "firmware/core/pulse.h"
#include "host/core/board.h"
#include "host/core/image.h"
#include "host/core/rigid3.h"
#include "host/core/scanner_model.h"

namespace stria {

/// A pulse that lies on the board.
struct StripePoint {
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    double s = 0;
    StripeMode mode = StripeMode::spacetime;
    double sigma = 0;  ///< spacetime: of s; spatial: of u, px
    double ds_dt = 0;  ///< of the axis then, per second
};

/// Axis position of a stripe point whose clock is late by the axis' delay.
inline double axis_position(const StripePoint& point, const AxisModel& axis) {
    return point.s + point.ds_dt * 1e-9 * axis.delay_ns;
}

/// Which parts of a board are one colour: a picture of it, looked up in mm.
class BoardColours {
  public:
    explicit BoardColours(const Board& board);
    /// True if the board point lies within the outermost corners.
    bool is_inside(const Eigen::Vector2d& on_board) const;
    /// 0 black to 255 white; only inside the printed pattern.
    int at(const Eigen::Vector2d& on_board) const;
    /// Corners (mm) of the rectangle that is_inside() means.
    const Eigen::Vector2d& min_mm() const { return min_mm_; }
    const Eigen::Vector2d& max_mm() const { return max_mm_; }

  private:
    GreyImage picture_;
    double px_per_mm_ = 1;
    Eigen::Vector2d origin_px_, min_mm_, max_mm_;
};

/// Every n-th row and column of a map, n the least that leaves no more than about `cells` of them.
PulseMap thinned(const PulseMap& pulses, int cells);

/// Board point (mm) that a pixel sees; empty if its ray leads away from the board's plane.
/// @param height_mm  of the board's surface there above its plane
std::optional<Eigen::Vector2d> seen_on_board(const CameraModel& camera,
                                             const Rigid3& camera_from_board,
                                             const Eigen::Vector2d& pixel, double height_mm = 0);

/// BoardRise where a pixel sees the surface of a board that bulges by `warp_mm`; 0 where it sees
/// none.
Eigen::Vector2d rise_seen(const CameraModel& camera, const Rigid3& camera_from_board,
                          const Eigen::Vector2d& pixel, const BoardRise& rise,
                          const Eigen::Vector2d& warp_mm);

/// Motion of the board, fixed to the part, from s = 0 to s, in the camera frame.
Rigid3 board_motion(const Channel& channel, double s);

/// Up to `most` pulses of the channel's laser on the board, spread evenly over the grid, the
/// strongest of a cell: unflagged, inside the outermost
/// corners, and with one colour all round (3 widths along the row for spatial peaks, which a
/// reflectance edge shifts; 2 px for spacetime pulses).
/// @param camera_from_board  at s = 0
std::vector<StripePoint> stripe_points_on_board(const PulseMap& pulses, const Channel& channel,
                                                const Rigid3& camera_from_board,
                                                const BoardColours& colours, int most);

/// Signed distance (mm) of the point where the pixel's ray meets the board from sheet(s).
/// @param height_mm  of the board's surface there above its plane
double distance_on_board(const Channel& channel, const Rigid3& camera_from_board,
                         const Eigen::Vector2d& pixel, double s, double height_mm = 0);

/// Standard deviation (mm) of that distance from the point's own sigma: its gradient along s (the
/// pixel kept) or along u (s kept), by central differences.
double sigma_on_board_mm(const Channel& channel, const Rigid3& camera_from_board,
                         const StripePoint& point);

}  // namespace stria

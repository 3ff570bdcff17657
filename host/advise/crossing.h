#pragma once
#include <Eigen/Core>
#include <optional>

#include "host/core/scanner_model.h"

namespace stria {

/// How the sheet of a scanner passes one surface point.
struct Crossing {
    Eigen::Vector3d point_in_camera = Eigen::Vector3d::Zero();  ///< mm
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    bool in_image = false;
    double s = 0;                  ///< axis position at which the sheet's centre is there
    LaserSheet sheet;              ///< at s
    double triangulation_rad = 0;  ///< between the camera's ray and the laser's
    double sin_to_sheet = 0;       ///< of the angle between the camera's ray and the sheet
    double mm_per_s = 0;           ///< way of the sheet across itself over the surface, a unit of s
    /// Shift of the measured point (camera frame, mm) by an error of one unit of s: along the ray
    /// on a swept machine, with the part on the others.
    Eigen::Vector3d shift_per_s = Eigen::Vector3d::Zero();
    double along_ray_mm_per_s = 0;  ///< way of the point along the ray, a unit of s: |dp/ds|
    double laser_mm = 0;            ///< from the laser's apex, folded path unfolded
    double pivot_mm = 0;            ///< from the mirror's axis, or the table's; infinite on a rail
};

/// Crossing of the point at `depth_mm` on the camera's middle ray (swept), or of the point of the
/// sheet at that depth in the middle row (rail, turntable; s = 0). Empty where the sheet does not
/// pass it before the camera, or the ray lies within 0.01 rad of the sheet.
/// @param field  other places of the image: (-1, -1) the top left pixel, (1, 1) the bottom right;
///               on rail and turntable the sheet decides about the first number
std::optional<Crossing> crossing_at_depth(const Channel& channel, double depth_mm,
                                          const Eigen::Vector2d& field = {0, 0});

/// Crossing of a point of the camera frame by a swept sheet. Empty as above.
std::optional<Crossing> swept_crossing(const Channel& channel,
                                       const Eigen::Vector3d& point_in_camera);

/// The largest range of s (from, to) over which the sheet passes what the camera sees at depths
/// `near_mm` to `far_mm`. Rail: until every point of the field's middle row has passed the sheet,
/// one field width. Turntable: a full turn. Empty if the sheet does not reach all of it.
struct AxisRange {
    double from = 0, to = 0;
};
std::optional<AxisRange> axis_range(const Channel& channel, double near_mm, double far_mm);

/// Full fan angle (rad) that lights the field's corners, edges and middle at those depths, without
/// the line's last percents, which fall off. 0 where the sheet passes none of them.
double fan_needed_rad(const Channel& channel, double near_mm, double far_mm);

}  // namespace stria

#pragma once
#include <Eigen/Core>
#include <vector>

#include "host/registration/scan_surface.h"

namespace stria {

/// What a scan saw in each direction from its camera, coarsely: to tell whether a point of another
/// scan lies in space that this one saw to be empty. For scans with one station or none
/// (orthographic); where the camera moved during the scan it gives no verdict.
class LineOfSight {
  public:
    /// @param cell_mm  width of a direction's cell at the surface
    LineOfSight(const ScanSurface& surface, double cell_mm);

    /// What the scan says about a place in its frame.
    enum class Verdict {
        unknown,   ///< outside the picture, no return there, or no verdict possible
        in_front,  ///< seen through: the scan saw a surface farther along the same line
        near,      ///< within the tolerance of the seen surface
        behind     ///< hidden by the seen surface
    };
    Verdict at(const Eigen::Vector3d& point_in_scan, double tolerance_mm) const;

  private:
    struct Seen {
        float least = 0, greatest = -1;  ///< depth, mm; least > greatest: nothing
    };
    /// Cell and depth of a place; false if outside.
    bool locate(const Eigen::Vector3d& point, int& x, int& y, double& depth) const;

    bool usable_ = false, perspective_ = false;
    Eigen::Vector3d eye_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();  ///< rows: right, up, into the picture
    Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
    double cell_ = 1;  ///< mm, or tangent of an angle
    int width_ = 0, height_ = 0;
    std::vector<Seen> seen_;
};

}  // namespace stria

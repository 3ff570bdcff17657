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
    enum class From { camera, laser };
    /// @param cell_mm  width of a direction's cell at the surface
    LineOfSight(const ScanSurface& surface, double cell_mm, From from = From::camera);

    /// What the scan says about a place in its frame.
    enum class Verdict {
        unknown,   ///< outside the picture, no return there, or no verdict possible
        in_front,  ///< seen through: the scan saw surface farther off along this line and all
                   ///< around it, so that no thin part or shadow's edge can be to blame
        near,      ///< within the tolerance of the seen surface
        behind     ///< hidden by the seen surface
    };
    Verdict at(const Eigen::Vector3d& point_in_scan, double tolerance_mm) const;

    /// True if nothing was seen along this line and all around it, although it is certain to have
    /// been in the picture: between what was seen, or anywhere if the whole part was in the
    /// picture.
    bool sees_nothing_at(const Eigen::Vector3d& point_in_scan) const;
    /// True if something seen along this line or beside it is nearer by more than the tolerance, or
    /// if no verdict is possible.
    bool may_be_hidden(const Eigen::Vector3d& point_in_scan, double tolerance_mm) const;
    /// Unit vector from the place to the camera or laser.
    Eigen::Vector3d towards_eye(const Eigen::Vector3d& point_in_scan) const;

  private:
    struct Seen {
        float least = 0, greatest = -1;  ///< depth, mm; least > greatest: nothing
    };
    /// All of the cell and its eight neighbours saw farther than `depth`.
    bool is_seen_through(int x, int y, double depth) const;
    /// Cell and depth of a place; false if outside.
    bool locate(const Eigen::Vector3d& point, int& x, int& y, double& depth) const;

    bool usable_ = false, perspective_ = false, whole_ = false;
    Eigen::Vector3d eye_ = Eigen::Vector3d::Zero();
    Eigen::Matrix3d axes_ = Eigen::Matrix3d::Identity();  ///< rows: right, up, into the picture
    Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
    double cell_ = 1;  ///< mm, or tangent of an angle
    int width_ = 0, height_ = 0;
    std::vector<Seen> seen_;
};

}  // namespace stria

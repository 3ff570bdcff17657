#pragma once
#include <functional>
#include <random>
#include <vector>

#include "host/fusion/fuse.h"

/// Range images of closed forms, for the tests of fusion.
namespace stria {

/// Orthographic image over [-half, half]^2 (scan frame, seen from +z): z(x, y), or nothing where it
/// is not a number.
RangeImage orthographic_image(double half_mm, double pitch_mm,
                              const std::function<double(double, double)>& z);

/// Image seen from one camera in the scan's origin looking along -z, with its laser apex to the
/// side: cell = direction. range(direction) in mm, or not a number for no return.
RangeImage perspective_image(const Eigen::Vector3d& laser, double half_angle_rad, int cells,
                             const std::function<double(const Eigen::Vector3d&)>& range);

/// Pose whose +z axis points along `up`, and whose origin is `at`.
Rigid3 looking_from(const Eigen::Vector3d& up, const Eigen::Vector3d& at = Eigen::Vector3d::Zero());

/// Twelve vertices of the icosahedron, unit.
std::vector<Eigen::Vector3d> icosahedron_directions();

/// Images with their poses.
struct Scans {
    std::vector<RangeImage> images;
    std::vector<Rigid3> poses;
    std::vector<FuseScan> list() const;
};

/// A sphere about the origin, orthographic, from the icosahedron's directions; Gaussian noise along
/// the line of sight.
Scans sphere_scans(double radius_mm, double pitch_mm, double noise_mm = 0);

}  // namespace stria

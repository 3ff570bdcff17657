#pragma once
#include <Eigen/Core>

namespace stria {

/// The laser's sheet of light, camera frame. Flat part: normal . p = offset_mm, unit normal,
/// offset_mm > 0. The apex lies in it; with the unit central ray c and t = normal x c the fan angle
/// of p is phi = atan2(t.(p-a), c.(p-a)); the bow lifts the sheet out of plane by the angle
/// bow2 phi^2 + bow3 phi^3 towards +normal.
struct LaserSheet {
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
    double offset_mm = 0;
    Eigen::Vector3d apex = Eigen::Vector3d::Zero();          ///< mm
    Eigen::Vector3d central_ray = Eigen::Vector3d::UnitZ();  ///< unit, in the sheet
    double bow2 = 0, bow3 = 0;                               ///< rad per rad^2, rad^3
    double fan_rad = 1.0;                                    ///< full opening angle
    double waist_sigma_mm = 0.1;  ///< Gaussian standard deviation across the sheet at the waist
    double waist_at_mm = 0;       ///< distance of the waist from the apex
    double wavelength_nm = 650;
};

/// Distance (mm) of a point from the (bowed) sheet, positive on the side of +normal.
double signed_distance(const LaserSheet& sheet, const Eigen::Vector3d& point_in_camera);
double fan_angle(const LaserSheet& sheet, const Eigen::Vector3d& point_in_camera);
/// Beam's standard deviation (mm) across the sheet at a point:
/// sigma0 sqrt(1 + (z / z_R)^2), z_R = 4 pi sigma0^2 / lambda (M^2 = 1).
double sigma_at(const LaserSheet& sheet, const Eigen::Vector3d& point_in_camera);

/// The sheet as a plane mirror m . (p - q) = h, m unit, shows it.
LaserSheet reflected(const LaserSheet& sheet, const Eigen::Vector3d& m, const Eigen::Vector3d& q,
                     double h);

/// The sheet with the apex and central ray projected into the plane, unit vectors, offset_mm > 0.
LaserSheet normalised(LaserSheet sheet);

}  // namespace stria

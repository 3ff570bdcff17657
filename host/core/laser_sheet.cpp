#include "host/core/laser_sheet.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace stria {

double fan_angle(const LaserSheet& sheet, const Eigen::Vector3d& point_in_camera) {
    const Eigen::Vector3d from_apex = point_in_camera - sheet.apex;
    const Eigen::Vector3d t = sheet.normal.cross(sheet.central_ray);
    return std::atan2(t.dot(from_apex), sheet.central_ray.dot(from_apex));
}

double signed_distance(const LaserSheet& sheet, const Eigen::Vector3d& point_in_camera) {
    const double flat = sheet.normal.dot(point_in_camera) - sheet.offset_mm;
    if (sheet.bow2 == 0 && sheet.bow3 == 0) return flat;
    const Eigen::Vector3d from_apex = point_in_camera - sheet.apex;
    const double radius = (from_apex - flat * sheet.normal).norm();
    const double phi = fan_angle(sheet, point_in_camera);
    const double bow = phi * phi * (sheet.bow2 + phi * sheet.bow3);
    return flat - radius * std::tan(bow);
}

double sigma_at(const LaserSheet& sheet, const Eigen::Vector3d& point_in_camera) {
    const double range_mm = (point_in_camera - sheet.apex).norm();
    const double rayleigh_mm = 4.0 * std::numbers::pi * sheet.waist_sigma_mm *
                               sheet.waist_sigma_mm / (sheet.wavelength_nm * 1e-6);
    const double ratio = (range_mm - sheet.waist_at_mm) / rayleigh_mm;
    return sheet.waist_sigma_mm * std::sqrt(1.0 + ratio * ratio);
}

LaserSheet reflected(const LaserSheet& sheet, const Eigen::Vector3d& m, const Eigen::Vector3d& q,
                     double h) {
    const auto turn = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
        return v - 2.0 * m.dot(v) * m;
    };
    LaserSheet image = sheet;
    image.normal = turn(sheet.normal);
    image.central_ray = turn(sheet.central_ray);
    image.apex = sheet.apex - 2.0 * (m.dot(sheet.apex - q) - h) * m;
    image.offset_mm = image.normal.dot(image.apex);
    // A mirror image turns t = normal x central_ray over: phi changes sign, and so does bow3.
    image.bow3 = -sheet.bow3;
    if (image.offset_mm < 0) {
        image.normal = -image.normal;
        image.offset_mm = -image.offset_mm;
        image.bow2 = -image.bow2;  // towards the other side; phi changes sign once more
    }
    return image;
}

LaserSheet normalised(LaserSheet sheet) {
    const double length = sheet.normal.norm();
    sheet.normal /= length;
    sheet.offset_mm /= length;
    if (sheet.offset_mm < 0) {
        sheet.normal = -sheet.normal;
        sheet.offset_mm = -sheet.offset_mm;
        sheet.bow2 = -sheet.bow2;
    }
    sheet.apex -= (sheet.normal.dot(sheet.apex) - sheet.offset_mm) * sheet.normal;
    sheet.central_ray -= sheet.normal.dot(sheet.central_ray) * sheet.normal;
    sheet.central_ray.normalize();
    return sheet;
}

}  // namespace stria

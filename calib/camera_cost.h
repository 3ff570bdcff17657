#pragma once
#include <ceres/rotation.h>

#include <Eigen/Core>

#include "host/core/camera_math.h"
#include "host/core/camera_model.h"
#include "host/core/rigid3.h"

/// For calib's own .cpp files only: templates that Ceres' dual numbers run through.
namespace stria {

constexpr int kCameraSize = 12;  ///< fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6
constexpr int kPoseSize = 6;     ///< rotation vector (rad), translation (mm)

/// Parameter block of a camera, unused distortion 0; and back.
Eigen::Matrix<double, kCameraSize, 1> camera_block(const CameraModel& camera);
void set_from_block(CameraModel& camera, const double* block);
/// Parameter block of a pose; and back.
Vector6d pose_block(const Rigid3& pose);
Rigid3 rigid_from_block(const double* block);

/// Pixel of a point in the camera frame; false if it is not in front of the camera.
template <typename T>
bool project_block(const T* camera, const T* point, T* pixel) {
    if (!(point[2] > T(1e-6))) return false;
    const T x = point[0] / point[2], y = point[1] / point[2];
    T xd, yd;
    camera_math::distort(camera + 4, x, y, xd, yd);
    pixel[0] = camera[0] * xd + camera[2];
    pixel[1] = camera[1] * yd + camera[3];
    return true;
}

/// pose * point.
template <typename T>
void move_by_block(const T* pose, const T* point, T* moved) {
    ceres::AngleAxisRotatePoint(pose, point, moved);
    for (int i = 0; i < 3; ++i) moved[i] += pose[3 + i];
}

/// Ray (x, y, 1) through a pixel. The point is undistorted in doubles and one Newton step in T then
/// gives exact first derivatives, at an eighth of undistort's cost.
template <typename T>
void ray_of_block(const T* camera, const Eigen::Vector2d& pixel, const double* camera_now, T* ray) {
    double x0, y0;
    camera_math::undistort(camera_now + 4, (pixel.x() - camera_now[2]) / camera_now[0],
                           (pixel.y() - camera_now[3]) / camera_now[1], x0, y0);
    const T xd = (pixel.x() - camera[2]) / camera[0], yd = (pixel.y() - camera[3]) / camera[1];
    // distort(x) = target: dx = J^-1 (target - distort(x0)), J in doubles by the same formulas.
    const double* d = camera_now + 4;
    const double r2 = x0 * x0 + y0 * y0;
    const double up = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
    const double down = 1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7]));
    const double up1 = d[0] + r2 * (2 * d[1] + 3 * r2 * d[4]);
    const double down1 = d[5] + r2 * (2 * d[6] + 3 * r2 * d[7]);
    const double radial = up / down, radial1 = (up1 - radial * down1) / down;
    const double j00 = radial + 2 * x0 * x0 * radial1 + 2 * d[2] * y0 + 6 * d[3] * x0;
    const double j01 = 2 * x0 * y0 * radial1 + 2 * d[2] * x0 + 2 * d[3] * y0;
    const double j11 = radial + 2 * y0 * y0 * radial1 + 6 * d[2] * y0 + 2 * d[3] * x0;
    const double det = j00 * j11 - j01 * j01;
    T dx, dy;
    camera_math::distort(camera + 4, T(x0), T(y0), dx, dy);
    const T ex = xd - dx, ey = yd - dy;
    ray[0] = x0 + (j11 * ex - j01 * ey) / det;
    ray[1] = y0 + (j00 * ey - j01 * ex) / det;
    ray[2] = T(1);
}

}  // namespace stria

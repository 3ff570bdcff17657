#pragma once
#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <cmath>

#include "calib/camera_cost.h"
#include "host/core/scanner_model.h"

/// For calib's own .cpp files only: sheet and axis of a channel as templates over differences from
/// a base channel, in perturbed()'s parameters, that Ceres' dual numbers run through.
namespace stria {

constexpr int kSheetSize = 5;  ///< tilt_a tilt_b offset bow2 bow3
/// Mirror: axis_a axis_b point_a point_b normal_a normal_b offset g2 g3.
/// Rail: direction_a direction_b. Turntable: rx ry rz tx ty tz.
constexpr int axis_size(MachineKind kind) {
    return kind == MachineKind::swept ? 9 : kind == MachineKind::rail ? 2 : 6;
}

template <typename T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

/// v turned by a and b about the two vectors of tangent_basis(v).
template <typename T>
Vec3<T> turned_by(const Eigen::Vector3d& v, const T& by_a, const T& by_b) {
    Eigen::Vector3d a, b;
    tangent_basis(v, a, b);
    const Vec3<T> w = a.cast<T>() * by_a + b.cast<T>() * by_b;
    const Vec3<T> from = v.cast<T>();
    Vec3<T> to;
    ceres::AngleAxisRotatePoint(w.data(), from.data(), to.data());
    return to;
}

template <typename T>
struct SheetOf {
    Vec3<T> normal, apex, central_ray;
    T offset, bow2, bow3;
};

/// The base sheet moved by `delta`.
template <typename T>
SheetOf<T> moved_sheet(const LaserSheet& base, const T* delta) {
    SheetOf<T> sheet;
    sheet.normal = turned_by(base.normal, delta[0], delta[1]);
    sheet.offset = base.offset_mm + delta[2];
    sheet.bow2 = base.bow2 + delta[3];
    sheet.bow3 = base.bow3 + delta[4];
    const Vec3<T> apex = base.apex.cast<T>(), ray = base.central_ray.cast<T>();
    sheet.apex = apex - sheet.normal * (sheet.normal.dot(apex) - sheet.offset);
    sheet.central_ray = ray - sheet.normal * sheet.normal.dot(ray);
    using std::sqrt;
    sheet.central_ray /= sqrt(sheet.central_ray.squaredNorm());
    return sheet;
}

template <typename T>
struct MirrorOf {
    Vec3<T> direction, point, normal0;
    Vec3<T> along, aside;  ///< normal0's part along direction; direction x normal0
    T offset, g2, g3;
};

template <typename T>
MirrorOf<T> moved_mirror(const MirrorAxis& base, const T* delta) {
    Eigen::Vector3d a, b;
    tangent_basis(base.direction, a, b);
    MirrorOf<T> mirror;
    mirror.direction = turned_by(base.direction, delta[0], delta[1]);
    mirror.point = base.point.cast<T>() + a.cast<T>() * delta[2] + b.cast<T>() * delta[3];
    mirror.normal0 = turned_by(base.normal0, delta[4], delta[5]);
    mirror.along = mirror.direction * mirror.direction.dot(mirror.normal0);
    mirror.aside = mirror.direction.cross(mirror.normal0);
    mirror.offset = base.offset_mm + delta[6];
    mirror.g2 = base.g2 + delta[7];
    mirror.g3 = base.g3 + delta[8];
    return mirror;
}

/// The sheet that the mirror shows at s. Its sign (towards which side of the sheet the normal
/// points) is not normalised. m(s) by Rodrigues' formula about the unit axis.
template <typename T>
SheetOf<T> reflected_sheet(const SheetOf<T>& sheet, const MirrorOf<T>& mirror, double s) {
    using std::cos;
    using std::sin;
    const T angle = s + s * s * (mirror.g2 + s * mirror.g3);
    const Vec3<T> m =
        mirror.along + (mirror.normal0 - mirror.along) * cos(angle) + mirror.aside * sin(angle);
    SheetOf<T> image = sheet;
    image.normal = sheet.normal - m * (2.0 * m.dot(sheet.normal));
    image.central_ray = sheet.central_ray - m * (2.0 * m.dot(sheet.central_ray));
    image.apex = sheet.apex - m * (2.0 * (m.dot(sheet.apex - mirror.point) - mirror.offset));
    image.offset = image.normal.dot(image.apex);
    image.bow3 = -sheet.bow3;
    return image;
}

/// As host/core's signed_distance().
template <typename T>
T distance_from(const SheetOf<T>& sheet, const Vec3<T>& p) {
    const T flat = sheet.normal.dot(p) - sheet.offset;
    const Vec3<T> from_apex = p - sheet.apex;
    const Vec3<T> inside = from_apex - sheet.normal * flat;
    const T along = sheet.central_ray.dot(inside);
    const T aside = sheet.normal.cross(sheet.central_ray).dot(inside);
    using std::atan2;
    using std::sqrt;
    using std::tan;
    const T phi = atan2(aside, along);
    const T radius = sqrt(along * along + aside * aside);
    return flat - radius * tan(phi * phi * (sheet.bow2 + phi * sheet.bow3));
}

/// Where a point that is at p (camera frame) when s = 0 is at s, by the axis moved by `delta`.
template <MachineKind kKind, typename T>
Vec3<T> moved_by_axis(const AxisModel& base, const T* delta, double s, const Vec3<T>& p) {
    if constexpr (kKind == MachineKind::swept) {
        return p;
    } else if constexpr (kKind == MachineKind::rail) {
        return p - turned_by(base.rail.direction, delta[0], delta[1]) * T(s);
    } else {
        const Rigid3& table = base.turntable.table_from_camera;
        const Vec3<T> on_base = table.rotation.cast<T>() * p + table.translation.cast<T>();
        Vec3<T> q;
        ceres::AngleAxisRotatePoint(delta, on_base.data(), q.data());
        for (int i = 0; i < 3; ++i) q[i] += delta[3 + i];
        const double c = std::cos(s), n = std::sin(s);
        const Vec3<T> turned(c * q[0] - n * q[1] - delta[3], n * q[0] + c * q[1] - delta[4],
                             q[2] - delta[5]);
        const T back[3] = {-delta[0], -delta[1], -delta[2]};
        Vec3<T> r;
        ceres::AngleAxisRotatePoint(back, turned.data(), r.data());
        return table.rotation.transpose().cast<T>() * (r - table.translation.cast<T>());
    }
}

/// Point (camera frame) where the ray meets the board, whose pose is that at s = 0.
template <MachineKind kKind, typename T>
Vec3<T> meet_board(const AxisModel& base, const T* axis_delta, const T* pose, const Vec3<T>& ray,
                   double s) {
    const T on_board[2][3] = {{T(0), T(0), T(0)}, {T(0), T(0), T(1)}};
    Vec3<T> at[2];
    for (int i = 0; i < 2; ++i) {
        Vec3<T> moved;
        move_by_block(pose, on_board[i], moved.data());
        at[i] = moved_by_axis<kKind>(base, axis_delta, s, moved);
    }
    const Vec3<T> normal = at[1] - at[0];
    return ray * (normal.dot(at[0]) / normal.dot(ray));
}

}  // namespace stria

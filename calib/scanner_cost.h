#pragma once
#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <cmath>

#include "calib/camera_cost.h"
#include "calib/stripe_points.h"
#include "host/core/scanner_model.h"

/// For calib's own .cpp files only: sheet and axis of a channel as templates over differences from
/// a base channel, in perturbed()'s parameters, that Ceres' dual numbers run through.
namespace stria {

constexpr int kSheetSize = 5;  ///< tilt_a tilt_b offset bow2 bow3
/// Mirror: axis_a axis_b point_a point_b normal_a normal_b offset g2 g3.
/// Rail: direction_a direction_b. Turntable: rx ry rz tx ty tz. All: then the delay, ns.
constexpr int axis_size(MachineKind kind) {
    return kind == MachineKind::swept ? 10 : kind == MachineKind::rail ? 3 : 7;
}
constexpr int kMostAxisSize = 10;

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

/// The base sheet in another plane, apex and central ray moved into it.
template <typename T>
SheetOf<T> sheet_in_plane(const LaserSheet& base, const Vec3<T>& normal, const T& offset,
                          const T* bow_delta) {
    SheetOf<T> sheet;
    sheet.normal = normal;
    sheet.offset = offset;
    sheet.bow2 = base.bow2 + bow_delta[0];
    sheet.bow3 = base.bow3 + bow_delta[1];
    const Vec3<T> apex = base.apex.cast<T>(), ray = base.central_ray.cast<T>();
    sheet.apex = apex - sheet.normal * (sheet.normal.dot(apex) - sheet.offset);
    sheet.central_ray = ray - sheet.normal * sheet.normal.dot(ray);
    using std::sqrt;
    sheet.central_ray /= sqrt(sheet.central_ray.squaredNorm());
    return sheet;
}

/// The base sheet moved by `delta`, whatever the axis.
template <typename T>
SheetOf<T> moved_sheet(const LaserSheet& base, const T* delta) {
    const Vec3<T> normal = turned_by(base.normal, delta[0], delta[1]);
    return sheet_in_plane(base, normal, T(base.offset_mm + delta[2]), delta + 3);
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

/// Turn of m0 about the mirror's axis that an axis difference holds, rad, to first order.
template <typename T>
T mirror_turn(const MirrorAxis& base, const T* delta) {
    Eigen::Vector3d a, b;
    tangent_basis(base.normal0, a, b);
    return delta[4] * a.dot(base.direction) + delta[5] * b.dot(base.direction);
}

/// The incoming sheet of a swept channel: moved by its own difference, then turned about the moved
/// mirror's axis by twice the turn of m0. What the mirror shows hardly changes when m0 turns and
/// the sheet follows so (not at all where m0 is square to an axis in the mirror's face), so the
/// direction that the data see least is a straight line of the parameters instead of a bent valley,
/// along which a solver would creep.
template <typename T>
SheetOf<T> following_sheet(const Channel& base, const T* sheet_delta, const T* axis_delta,
                           const MirrorOf<T>& mirror) {
    const Vec3<T> own = turned_by(base.sheet.normal, sheet_delta[0], sheet_delta[1]);
    const Vec3<T> turn = mirror.direction * (mirror_turn(base.axis.mirror, axis_delta) * 2.0);
    Vec3<T> normal;
    ceres::AngleAxisRotatePoint(turn.data(), own.data(), normal.data());
    const T offset = base.sheet.offset_mm + sheet_delta[2] + (normal - own).dot(mirror.point);
    return sheet_in_plane(base.sheet, normal, offset, sheet_delta + 3);
}

/// The sheet (swept: the incoming one) of a channel moved by its differences.
template <MachineKind kKind, typename T>
SheetOf<T> sheet_of(const Channel& base, const T* sheet_delta, const T* axis_delta) {
    if constexpr (kKind == MachineKind::swept)
        return following_sheet(base, sheet_delta, axis_delta,
                               moved_mirror(base.axis.mirror, axis_delta));
    else
        return moved_sheet(base.sheet, sheet_delta);
}

/// The sheet that the mirror shows at s. Its sign (towards which side of the sheet the normal
/// points) is not normalised. m(s) by Rodrigues' formula about the unit axis.
template <typename T>
SheetOf<T> reflected_sheet(const SheetOf<T>& sheet, const MirrorOf<T>& mirror, const T& s) {
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

/// Axis position at a stripe point, the delay moved by the last entry of the axis' difference.
template <MachineKind kKind, typename T>
T delayed_s(const StripePoint& point, const AxisModel& base, const T* axis_delta) {
    return axis_delta[axis_size(kKind) - 1] * (1e-9 * point.ds_dt) + axis_position(point, base);
}

/// Where a point that is at p (camera frame) when s = 0 is at s, by the axis moved by `delta`.
template <MachineKind kKind, typename T>
Vec3<T> moved_by_axis(const AxisModel& base, const T* delta, const T& s, const Vec3<T>& p) {
    if constexpr (kKind == MachineKind::swept) {
        return p;
    } else if constexpr (kKind == MachineKind::rail) {
        return p - turned_by(base.rail.direction, delta[0], delta[1]) * s;
    } else {
        const Rigid3& table = base.turntable.table_from_camera;
        const Vec3<T> on_base = table.rotation.cast<T>() * p + table.translation.cast<T>();
        Vec3<T> q;
        ceres::AngleAxisRotatePoint(delta, on_base.data(), q.data());
        for (int i = 0; i < 3; ++i) q[i] += delta[3 + i];
        using std::cos;
        using std::sin;
        const T c = cos(s), n = sin(s);
        const Vec3<T> turned(c * q[0] - n * q[1] - delta[3], n * q[0] + c * q[1] - delta[4],
                             q[2] - delta[5]);
        const T back[3] = {-delta[0], -delta[1], -delta[2]};
        Vec3<T> r;
        ceres::AngleAxisRotatePoint(back, turned.data(), r.data());
        return table.rotation.transpose().cast<T>() * (r - table.translation.cast<T>());
    }
}

inline constexpr int kWarpSize = 2;  ///< Board::warp_mm

/// A point of the board and how it rises with the warp, see BoardRise.
struct BoardPoint {
    Eigen::Vector2d on_board, rise;

    template <typename T>
    Vec3<T> bent_by(const T* warp) const {
        return Vec3<T>(T(on_board.x()), T(on_board.y()), warp[0] * rise.x() + warp[1] * rise.y());
    }
};

/// Point (camera frame) where the ray meets the board, whose pose is that at s = 0, and whose
/// surface there is `height` (mm) above its plane.
template <MachineKind kKind, typename T>
Vec3<T> meet_board(const AxisModel& base, const T* axis_delta, const T* pose, const Vec3<T>& ray,
                   const T& s, const T& height) {
    const T on_board[2][3] = {{T(0), T(0), T(0)}, {T(0), T(0), T(1)}};
    Vec3<T> at[2];
    for (int i = 0; i < 2; ++i) {
        Vec3<T> moved;
        move_by_block(pose, on_board[i], moved.data());
        at[i] = moved_by_axis<kKind>(base, axis_delta, s, moved);
    }
    const Vec3<T> normal = at[1] - at[0];
    return ray * ((normal.dot(at[0]) + height) / normal.dot(ray));
}

}  // namespace stria

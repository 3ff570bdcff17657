#include "host/advise/crossing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stria {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFarthest_rad = 0.8;  ///< a mirror is not turned farther from s = 0
constexpr double kEvenShare = 0.98;    ///< of a line's length, before its ends fall off

Vector2d pixel_at(const CameraModel& camera, const Vector2d& field) {
    return {0.5 * (camera.width - 1) * (1 + field.x()),
            0.5 * (camera.height - 1) * (1 + field.y())};
}

/// s in [-0.8, 0.8] nearest 0 at which the sheet holds p: sign changes found, then halved.
std::optional<double> passing_s(const Channel& channel, const Vector3d& p) {
    const auto distance = [&](double s) {
        const LaserSheet sheet = sheet_at(channel, s);
        // The sheet's other half leads away from the laser.
        if (sheet.central_ray.dot(p - sheet.apex) <= 0)
            return std::numeric_limits<double>::quiet_NaN();
        // One orientation for all s: normals turn over where the offset changes sign.
        const Vector3d t = channel.axis.mirror.direction;
        const double turned = sheet.central_ray.cross(t).dot(sheet.normal) < 0 ? -1 : 1;
        return turned * signed_distance(sheet, p);
    };
    constexpr double kStride = 0.01;
    for (double reach = 0; reach < kFarthest_rad; reach += kStride)
        for (const double side : {1.0, -1.0}) {
            double a = side * reach, b = side * (reach + kStride);
            double at_a = distance(a);
            const double at_b = distance(b);
            if (!(at_a * at_b <= 0)) continue;
            for (int i = 0; i < 60; ++i) {
                const double middle = (a + b) / 2, at_middle = distance(middle);
                const bool beyond = at_a * at_middle > 0;
                if (beyond) at_a = at_middle;
                (beyond ? a : b) = middle;
            }
            return (a + b) / 2;
        }
    return std::nullopt;
}

double pivot_distance(const Channel& channel, const Vector3d& p) {
    switch (channel.axis.kind) {
        case MachineKind::swept: {
            const Vector3d d = channel.axis.mirror.direction;
            const Vector3d from = p - channel.axis.mirror.point;
            return (from - d.dot(from) * d).norm();
        }
        case MachineKind::rail:
            return std::numeric_limits<double>::infinity();
        case MachineKind::turntable:
            return (channel.axis.turntable.table_from_camera * p).head<2>().norm();
    }
    return 0;
}

std::optional<Crossing> crossing_of(const Channel& channel, const Vector3d& p, double s) {
    const auto pixel = project(channel.camera, p);
    if (!pixel) return std::nullopt;
    const auto hit = triangulate(channel, *pixel, s);
    if (!hit) return std::nullopt;
    Crossing crossing;
    crossing.point_in_camera = p;
    crossing.pixel = *pixel;
    crossing.in_image = channel.camera.contains(*pixel);
    crossing.s = s;
    crossing.sheet = sheet_at(channel, s);
    const Vector3d from_laser = p - crossing.sheet.apex;
    const Vector3d ray = p.normalized();
    crossing.triangulation_rad = std::acos(std::clamp(ray.dot(from_laser.normalized()), -1.0, 1.0));
    crossing.sin_to_sheet = std::abs(crossing.sheet.normal.dot(ray));
    const Eigen::Matrix3d scan_from_camera_turn = scan_from_camera(channel, s).rotation;
    const Vector3d n = scan_from_camera_turn * crossing.sheet.normal;
    crossing.shift_per_s = scan_from_camera_turn.transpose() * hit->d_point_d_s;
    crossing.mm_per_s = std::abs(n.dot(hit->d_point_d_s));
    crossing.along_ray_mm_per_s = crossing.mm_per_s / crossing.sin_to_sheet;
    crossing.laser_mm = from_laser.norm();
    crossing.pivot_mm = pivot_distance(channel, p);
    return crossing;
}

}  // namespace

std::optional<Crossing> swept_crossing(const Channel& channel, const Vector3d& p) {
    const auto s = passing_s(channel, p);
    return s ? crossing_of(channel, p, *s) : std::nullopt;
}

std::optional<Crossing> crossing_at_depth(const Channel& channel, double depth_mm,
                                          const Vector2d& field) {
    const Vector3d ray = ray_through(channel.camera, pixel_at(channel.camera, field));
    if (channel.axis.kind == MachineKind::swept) return swept_crossing(channel, depth_mm * ray);
    // On the sheet, in that row: x from the plane, then once more for the bow.
    const LaserSheet& sheet = channel.sheet;
    Vector3d p = depth_mm * ray;
    for (int i = 0; i < 20; ++i) {
        if (std::abs(sheet.normal.x()) < 1e-3) return std::nullopt;
        p.x() -= signed_distance(sheet, p) / sheet.normal.x();
    }
    if (sheet.central_ray.dot(p - sheet.apex) <= 0) return std::nullopt;
    return crossing_of(channel, p, 0);
}

std::optional<AxisRange> axis_range(const Channel& channel, double near_mm, double far_mm) {
    const CameraModel& camera = channel.camera;
    if (channel.axis.kind == MachineKind::turntable) return AxisRange{0, 2 * std::numbers::pi};
    if (channel.axis.kind == MachineKind::rail) {
        const double half = 0.25 * (near_mm + far_mm) * camera.width / camera.fx;
        return AxisRange{-half, half};
    }
    AxisRange range{1e300, -1e300};
    for (const double depth_mm : {near_mm, far_mm})
        for (const double u : {0.0, camera.width - 1.0})
            for (const double v : {0.0, camera.height - 1.0}) {
                const auto s = passing_s(channel, depth_mm * ray_through(camera, {u, v}));
                if (!s) return std::nullopt;
                range.from = std::min(range.from, *s);
                range.to = std::max(range.to, *s);
            }
    return range;
}

double fan_needed_rad(const Channel& channel, double near_mm, double far_mm) {
    double half_rad = 0;
    for (const double depth_mm : {near_mm, (near_mm + far_mm) / 2, far_mm})
        for (const double v : {-1.0, 0.0, 1.0})
            for (const double u : {-1.0, 0.0, 1.0}) {
                if (u != 0 && channel.axis.kind != MachineKind::swept) continue;
                const auto crossing = crossing_at_depth(channel, depth_mm, {u, v});
                if (!crossing) continue;
                half_rad = std::max(
                    half_rad, std::abs(fan_angle(crossing->sheet, crossing->point_in_camera)));
            }
    return 2 * half_rad / kEvenShare;
}

}  // namespace stria

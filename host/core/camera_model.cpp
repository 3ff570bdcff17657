#include "host/core/camera_model.h"

#include <cmath>

#include "host/core/camera_math.h"

namespace stria {

const char* name_of(LensKind kind) {
    switch (kind) {
        case LensKind::pinhole:
            return "pinhole";
        case LensKind::brown5:
            return "brown5";
        case LensKind::rational8:
            return "rational8";
    }
    return "?";
}

std::optional<LensKind> lens_kind_from(const std::string& name) {
    for (LensKind kind : {LensKind::pinhole, LensKind::brown5, LensKind::rational8})
        if (name == name_of(kind)) return kind;
    return std::nullopt;
}

int distortion_count(LensKind kind) {
    return kind == LensKind::pinhole ? 0 : kind == LensKind::brown5 ? 5 : 8;
}

std::optional<Eigen::Vector2d> project(const CameraModel& camera,
                                       const Eigen::Vector3d& point_in_camera) {
    if (!(point_in_camera.z() > 0)) return std::nullopt;
    const double x = point_in_camera.x() / point_in_camera.z();
    const double y = point_in_camera.y() / point_in_camera.z();
    double xd = x, yd = y;
    if (camera.kind != LensKind::pinhole)
        camera_math::distort(camera.distortion.data(), x, y, xd, yd);
    return Eigen::Vector2d(camera.fx * xd + camera.cx, camera.fy * yd + camera.cy);
}

Eigen::Vector3d ray_through(const CameraModel& camera, const Eigen::Vector2d& pixel) {
    const double xd = (pixel.x() - camera.cx) / camera.fx;
    const double yd = (pixel.y() - camera.cy) / camera.fy;
    double x = xd, y = yd;
    if (camera.kind != LensKind::pinhole)
        camera_math::undistort(camera.distortion.data(), xd, yd, x, y);
    return {x, y, 1.0};
}

std::string validate(const CameraModel& camera) {
    const auto bad = [](const char* field, double value, const char* bound) {
        return std::string(field) + " = " + std::to_string(value) + ": expected " + bound;
    };
    if (camera.width < 1 || camera.width > 16384) return bad("width", camera.width, "1 to 16384");
    if (camera.height < 1 || camera.height > 16384)
        return bad("height", camera.height, "1 to 16384");
    if (!(camera.fx > 0 && std::isfinite(camera.fx))) return bad("fx", camera.fx, "above 0");
    if (!(camera.fy > 0 && std::isfinite(camera.fy))) return bad("fy", camera.fy, "above 0");
    if (!std::isfinite(camera.cx)) return bad("cx", camera.cx, "a finite number");
    if (!std::isfinite(camera.cy)) return bad("cy", camera.cy, "a finite number");
    for (double k : camera.distortion)
        if (!std::isfinite(k)) return bad("distortion", k, "finite numbers");
    return "";
}

}  // namespace stria

#pragma once
#include <string>

#include "sim/scene.h"

/// Pieces that many scenes of tests are made of.
namespace stria::test {

/// A pinhole camera with its principal point in the middle.
inline CameraModel pinhole(int width, int height, double focal_px) {
    return {.kind = LensKind::pinhole,
            .width = width,
            .height = height,
            .fx = focal_px,
            .fy = focal_px,
            .cx = 0.5 * (width - 1),
            .cy = 0.5 * (height - 1)};
}

/// Keeps the middle of the camera's image, of that size.
inline void crop_to_middle(CameraModel& camera, int width, int height) {
    camera.cx += 0.5 * (width - camera.width);
    camera.cy += 0.5 * (height - camera.height);
    camera.width = width;
    camera.height = height;
}

/// A plane from `corner` on, `size` large, both along its own x and y (mm).
inline SceneObject rectangle(const std::string& name, const Eigen::Vector2d& corner,
                             const Eigen::Vector2d& size, const Rigid3& world_from_object) {
    SceneObject object;
    object.name = name;
    object.shape = SceneShape::plane;
    object.corner_mm = corner;
    object.size_mm = size;
    object.world_from_object = world_from_object;
    return object;
}

/// A square plate that faces the camera's axis.
inline SceneObject plate(double depth_mm, double side_mm = 600) {
    const Eigen::Vector2d size(side_mm, side_mm);
    return rectangle("plate", -size / 2, size,
                     {Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, -depth_mm)});
}

}  // namespace stria::test

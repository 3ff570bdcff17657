#pragma once
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

/// A square plate that faces the camera's axis.
inline SceneObject plate(double depth_mm, double side_mm = 600) {
    SceneObject object;
    object.name = "plate";
    object.shape = SceneShape::plane;
    object.size_mm = {side_mm, side_mm};
    object.corner_mm = -object.size_mm / 2;
    object.world_from_object.translation = {0, 0, -depth_mm};
    return object;
}

}  // namespace stria::test

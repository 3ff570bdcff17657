#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

namespace stria {

enum class LensKind { pinhole, brown5, rational8 };

/// Names of camera.toml: "pinhole", "brown5", "rational8".
const char* name_of(LensKind kind);
std::optional<LensKind> lens_kind_from(const std::string& name);
/// Coefficients the kind uses: 0, 5, 8.
int distortion_count(LensKind kind);

/// A camera: origin at its optical centre, x right, y down, z forward. Pixel (0, 0) is the centre
/// of the top-left pixel. distortion is k1 k2 p1 p2 k3 k4 k5 k6 as OpenCV defines them, unused
/// ones 0.
struct CameraModel {
    LensKind kind = LensKind::pinhole;
    int width = 0;
    int height = 0;
    double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
    std::array<double, 8> distortion{};

    bool contains(const Eigen::Vector2d& pixel) const {
        return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() <= width - 0.5 &&
               pixel.y() <= height - 0.5;
    }
};

/// Pixel of a point (mm, camera frame); empty if it is not in front of the camera. May lie outside
/// the image.
std::optional<Eigen::Vector2d> project(const CameraModel& camera,
                                       const Eigen::Vector3d& point_in_camera);

/// Direction (x, y, 1) of the ray through a pixel, camera frame.
Eigen::Vector3d ray_through(const CameraModel& camera, const Eigen::Vector2d& pixel);

/// Empty if usable, else what is wrong (field, value, bound).
std::string validate(const CameraModel& camera);

}  // namespace stria

#pragma once
#include <random>
#include <string>

#include "calib/camera_calibration.h"
#include "host/core/board.h"
#include "host/core/camera_model.h"

/// Corners of boards as an ideal camera sees them, with Gaussian noise: truth for calibration
/// tests.
namespace stria {

/// A lens of 65 deg across with the distortion that is usual for it.
inline CameraModel webcam() {
    CameraModel camera;
    camera.kind = LensKind::brown5;
    camera.width = 1280;
    camera.height = 960;
    camera.fx = camera.fy = 1000;
    camera.cx = 645;
    camera.cy = 473;
    camera.distortion = {-0.12, 0.07, 5e-4, -3e-4, -0.01};
    return camera;
}

/// Board turned by up to max_tilt_rad to a random side and by any angle in its plane, its middle at
/// `centre` (camera frame, mm).
inline Rigid3 random_board_pose(std::mt19937& rng, const Board& board,
                                const Eigen::Vector3d& centre, double max_tilt_rad,
                                double max_roll_rad = 3.14159) {
    std::uniform_real_distribution<double> unit(-1, 1);
    const double side = 3.14159 * unit(rng), tilt = max_tilt_rad * std::sqrt(std::abs(unit(rng)));
    const Eigen::Matrix3d rotation =
        rotation_from_vector({tilt * std::cos(side), tilt * std::sin(side), 0}) *
        rotation_from_vector({0, 0, max_roll_rad * unit(rng)});
    const auto points = board_points(board);
    const Eigen::Vector3d middle = 0.5 * (points.front() + points.back());
    return {rotation, centre - rotation * middle};
}

/// The board's points inside the image, noisy.
inline CameraView seen_by(const CameraModel& camera, const Rigid3& camera_from_board,
                          const Board& board, double noise_px, std::mt19937& rng) {
    std::normal_distribution<double> noise(0, noise_px);
    CameraView view;
    const auto points = board_points(board);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto pixel = project(camera, camera_from_board * points[i]);
        if (!pixel || !camera.contains(*pixel)) continue;
        view.ids.push_back(static_cast<int>(i));
        view.pixels.push_back(*pixel + Eigen::Vector2d(noise(rng), noise(rng)));
    }
    return view;
}

}  // namespace stria

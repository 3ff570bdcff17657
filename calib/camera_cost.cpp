#include "calib/camera_cost.h"

#include <algorithm>

namespace stria {

Eigen::Matrix<double, kCameraSize, 1> camera_block(const CameraModel& camera) {
    Eigen::Matrix<double, kCameraSize, 1> block;
    block << camera.fx, camera.fy, camera.cx, camera.cy,
        Eigen::Map<const Eigen::Matrix<double, 8, 1>>(camera.distortion.data());
    for (int i = distortion_count(camera.kind); i < 8; ++i) block[4 + i] = 0;
    return block;
}

void set_from_block(CameraModel& camera, const double* block) {
    camera.fx = block[0];
    camera.fy = block[1];
    camera.cx = block[2];
    camera.cy = block[3];
    std::copy(block + 4, block + 12, camera.distortion.begin());
}

Vector6d pose_block(const Rigid3& pose) {
    Vector6d block;
    block << vector_from_rotation(pose.rotation), pose.translation;
    return block;
}

Rigid3 rigid_from_block(const double* block) {
    return {rotation_from_vector(Eigen::Vector3d(block[0], block[1], block[2])),
            Eigen::Vector3d(block[3], block[4], block[5])};
}

}  // namespace stria

#include "tests/support/measured_object.h"

#include <Eigen/Geometry>
#include <random>

#include "tests/support/bumpy_shape.h"

namespace stria::test_support {

using Eigen::Vector3d;

TriMesh measured_object() { return testing::make_bumpy_shape(kMeasuredObject); }

std::vector<Rigid3> measured_object_poses() {
    std::mt19937 rng(kMeasuredObject);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<Rigid3> poses;
    for (const Vector3d& towards : testing::spread_directions(kMeasuredObjectViews)) {
        const Eigen::Matrix3d turn =
            rotation_from_vector({0, 0, 3 * unit(rng)}) *
            Eigen::Quaterniond::FromTwoVectors(towards, Vector3d::UnitZ()).toRotationMatrix();
        poses.push_back({turn, Vector3d(3 * unit(rng), 3 * unit(rng), -450 + 3 * unit(rng))});
    }
    return poses;
}

}  // namespace stria::test_support

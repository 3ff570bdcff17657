#include "calib/axis_start.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>

namespace stria {
namespace {

constexpr double kLeastTravelMm = 5;
constexpr double kLeastTurnRad = 0.05;

/// Calls use(ds, from, to) for the first picture of each view against each later one far enough.
template <typename Use>
void for_each_move(const std::vector<PosesAlongAxis>& views, double least, const Use& use) {
    for (const PosesAlongAxis& view : views)
        for (std::size_t i = 1; i < view.s.size(); ++i) {
            const double ds = view.s[i] - view.s[0];
            if (std::abs(ds) >= least)
                use(ds, view.camera_from_board[0], view.camera_from_board[i]);
        }
}

AxisStart start_rail(const AxisModel& nominal, const std::vector<PosesAlongAxis>& views) {
    // p_camera(s) = p_camera(0) - s d for every point of a board at rest.
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double squares = 0;
    for_each_move(views, kLeastTravelMm, [&](double ds, const Rigid3& from, const Rigid3& to) {
        sum -= ds * (to.translation - from.translation);
        squares += ds * ds;
    });
    AxisStart start{nominal};
    if (squares == 0 || !(sum.norm() > 0)) return start;
    start.axis.rail.direction = sum.normalized();
    start.from_views = true;
    start.scale = sum.norm() / squares;
    return start;
}

AxisStart start_table(const AxisModel& nominal, const std::vector<PosesAlongAxis>& views) {
    // In the camera frame the board turns by +ds about the table's z: to = turn * from.
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();
    Eigen::Matrix3d normal_matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
    double turned = 0, stated = 0;
    for_each_move(views, kLeastTurnRad, [&](double ds, const Rigid3& from, const Rigid3& to) {
        const Rigid3 motion = to * from.inverse();
        const Eigen::Vector3d w = vector_from_rotation(motion.rotation);
        axis += ds * w;
        turned += std::abs(w.norm());
        stated += std::abs(std::remainder(ds, 2 * 3.14159265358979));
        // A point c of the axis stays: (1 - R) c = t.
        const Eigen::Matrix3d still = Eigen::Matrix3d::Identity() - motion.rotation;
        normal_matrix += still.transpose() * still;
        right_side += still.transpose() * motion.translation;
    });
    AxisStart start{nominal};
    if (!(axis.norm() > 0)) return start;
    axis.normalize();
    const Rigid3 camera_from_table = nominal.turntable.table_from_camera.inverse();
    // Of the points on the axis the one nearest the nominal's origin.
    const Eigen::Vector3d origin = camera_from_table.translation;
    const Eigen::Matrix3d along = axis * axis.transpose();
    const double weight = normal_matrix.trace();
    const Eigen::Vector3d centre =
        (normal_matrix + weight * along).ldlt().solve(right_side + weight * along * origin);
    const Eigen::Matrix3d tilt =
        Eigen::Quaterniond::FromTwoVectors(camera_from_table.rotation.col(2), axis)
            .toRotationMatrix();
    start.axis.turntable.table_from_camera =
        Rigid3{tilt * camera_from_table.rotation, centre}.inverse();
    start.from_views = true;
    start.scale = turned / stated;
    return start;
}

}  // namespace

AxisStart start_axis(const AxisModel& nominal, const std::vector<PosesAlongAxis>& views) {
    switch (nominal.kind) {
        case MachineKind::swept:
            break;
        case MachineKind::rail:
            return start_rail(nominal, views);
        case MachineKind::turntable:
            return start_table(nominal, views);
    }
    return {nominal};
}

}  // namespace stria

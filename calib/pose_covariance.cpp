#include "calib/pose_covariance.h"

#include <Eigen/Dense>
#include <stdexcept>

namespace stria {

Matrix6d pose_covariance(const CameraModel& camera, const Rigid3& camera_from_board,
                         const CameraView& view, const Board& board) {
    const auto points = board_points(board);
    Matrix6d information = Matrix6d::Zero();
    Vector6d step;  // rad, mm: central differences of a smooth function, error of order step^2
    step << 1e-5, 1e-5, 1e-5, 1e-2, 1e-2, 1e-2;
    for (const int id : view.ids) {
        const Eigen::Vector3d at = camera_from_board * points[static_cast<std::size_t>(id)];
        Eigen::Matrix<double, 2, 6> rows;
        bool seen = true;
        for (int k = 0; k < 6; ++k) {
            Vector6d delta = Vector6d::Zero();
            delta[k] = step[k];
            const auto after = project(camera, rigid_from_vector(delta) * at);
            const auto before = project(camera, rigid_from_vector(-delta) * at);
            seen = seen && after && before;
            if (seen) rows.col(k) = (*after - *before) / (2 * step[k]);
        }
        if (seen) information += rows.transpose() * rows;
    }
    // Turns and shifts have different sizes: compared only after scaling.
    const Vector6d scale = information.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
    const Matrix6d scaled = scale.asDiagonal() * information * scale.asDiagonal();
    const Eigen::LDLT<Matrix6d> factor(scaled);
    if (!(factor.rcond() > 1e-14) || !factor.isPositive())
        throw std::invalid_argument("view " + view.name + ": " + std::to_string(view.ids.size()) +
                                    " corners do not determine the board's pose");
    return scale.asDiagonal() * factor.solve(Matrix6d::Identity()) * scale.asDiagonal();
}

}  // namespace stria

#include <ceres/autodiff_cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <memory>

#include "calib/scanner_residuals.h"
#include "calib/stripe_points.h"
#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

Rigid3 some_pose() {
    return {rotation_from_vector({0.3, -0.2, 0.5}), Eigen::Vector3d(-80, -60, 480)};
}

/// perturbed() by those differences; on a swept machine with the sheet turned about the moved
/// mirror's axis by twice the turn of m0.
template <MachineKind kKind>
Channel moved_channel(const ScannerModel& base, const double* sheet, const double* axis) {
    constexpr int kAxis = axis_size(kKind);
    Eigen::VectorXd delta = Eigen::VectorXd::Zero(9 + kSheetSize + kAxis);
    for (int i = 0; i < kSheetSize; ++i) delta[9 + i] = sheet[i];
    for (int i = 0; i < kAxis; ++i) delta[9 + kSheetSize + i] = axis[i];
    Channel moved = perturbed(base, delta).channels[0];
    if (kKind == MachineKind::swept) {
        const MirrorAxis &from = base.channels[0].axis.mirror, &to = moved.axis.mirror;
        Eigen::Vector3d a, b;
        tangent_basis(from.normal0, a, b);
        const double turn = (axis[4] * a + axis[5] * b).dot(from.direction);
        const Eigen::Vector3d old = moved.sheet.normal;
        moved.sheet.normal = rotation_from_vector(2 * turn * to.direction) * old;
        moved.sheet.offset_mm += (moved.sheet.normal - old).dot(to.point);
        moved.sheet.apex = base.channels[0].sheet.apex;
        moved.sheet.central_ray = base.channels[0].sheet.central_ray;
        moved.sheet = normalised(moved.sheet);
    }
    return moved;
}

/// The templates at some differences against host/core's perturbed(), sheet_at() and
/// scan_from_camera(); and the derivatives against central differences of the residual.
template <MachineKind kKind>
void compare_with_core() {
    std::mt19937 rng(31);
    const ScannerModel base = built_scanner(drawn_scanner(kKind), rng);
    constexpr int kAxis = axis_size(kKind);
    const Vector6d pose = pose_block(some_pose());
    std::normal_distribution<double> unit(0, 1);
    for (int trial = 0; trial < 50; ++trial) {
        double sheet[kSheetSize], axis[kAxis];
        for (double& d : sheet) d = 3e-3 * unit(rng);
        for (double& d : axis) d = 3e-3 * unit(rng);
        axis[kAxis - 1] = 1e6 * unit(rng);  // ns
        const Eigen::Matrix<double, kCameraSize, 1> camera = camera_block(base.channels[0].camera);
        StripePoint point;
        point.s = (kKind == MachineKind::rail ? 50 : 0.1) * unit(rng);
        point.ds_dt = (kKind == MachineKind::rail ? 20 : 0.3) * (trial % 2 ? 1 : -1);
        point.pixel = {640 + 200 * unit(rng), 512 + 150 * unit(rng)};

        const Channel moved = moved_channel<kKind>(base, sheet, axis);
        const Eigen::Vector2d rise(0.7, 0.4), warp(unit(rng), unit(rng));
        const double wanted = distance_on_board(moved, some_pose(), point.pixel,
                                                axis_position(point, moved.axis), rise.dot(warp));

        const StripeCost<kKind> cost(&base.channels[0], std::make_shared<LightAt<kKind>>(), point,
                                     rise, 1.0);
        const double* blocks[] = {camera.data(), sheet, axis, pose.data(), warp.data()};
        double residual = 0;
        Eigen::VectorXd by[5] = {Eigen::VectorXd(12), Eigen::VectorXd(5), Eigen::VectorXd(kAxis),
                                 Eigen::VectorXd(6), Eigen::VectorXd(2)};
        double* jacobians[] = {by[0].data(), by[1].data(), by[2].data(), by[3].data(),
                               by[4].data()};
        ASSERT_TRUE(cost.Evaluate(blocks, &residual, jacobians));
        // mm, up to the side the normal points to; rounding at 500 mm
        EXPECT_NEAR(std::abs(residual), std::abs(wanted), 1e-9) << name_of(kKind);

        const int sizes[] = {12, 5, kAxis, 6, 2};
        for (int b = 0; b < 5; ++b)
            for (int i = 0; i < sizes[b]; ++i) {
                Eigen::VectorXd block = Eigen::Map<const Eigen::VectorXd>(blocks[b], sizes[b]);
                const double h = b == 2 && i == kAxis - 1 ? 1e4 : 1e-6;  // ns; rad, mm, ...
                const double* changed[] = {blocks[0], blocks[1], blocks[2], blocks[3], blocks[4]};
                changed[b] = block.data();
                double after = 0, before = 0;
                block[i] += h;
                cost.Evaluate(changed, &after, nullptr);
                block[i] -= 2 * h;
                cost.Evaluate(changed, &before, nullptr);
                const double slope = (after - before) / (2 * h);
                // rounding of 1e-11 mm over the step
                EXPECT_NEAR(by[b][i], slope, 1e-5 * std::abs(slope) + 1e-11 / h)
                    << name_of(kKind) << " block " << b << " entry " << i;
            }
    }
}

/// The same for corners that the axis moves.
template <MachineKind kKind>
void compare_corners() {
    std::mt19937 rng(32);
    const ScannerModel base = built_scanner(drawn_scanner(kKind), rng);
    constexpr int kAxis = axis_size(kKind);
    const Vector6d pose = pose_block(some_pose());
    const Eigen::Matrix<double, kCameraSize, 1> camera = camera_block(base.channels[0].camera);
    std::normal_distribution<double> unit(0, 1);
    for (int trial = 0; trial < 20; ++trial) {
        double sheet[kSheetSize] = {}, axis[kAxis];
        for (double& d : axis) d = 3e-3 * unit(rng);
        const double s = (kKind == MachineKind::rail ? 50 : 0.5) * unit(rng);
        const BoardPoint point{{60 + 30 * unit(rng), 60 + 30 * unit(rng)}, {0.7, 0.4}};
        const Eigen::Vector2d warp(unit(rng), unit(rng));
        const Channel moved = moved_channel<kKind>(base, sheet, axis);
        const auto wanted = project(
            moved.camera, board_motion(moved, s) * some_pose() * point.bent_by(warp.data()));
        ASSERT_TRUE(wanted);
        const ceres::AutoDiffCostFunction<CornerCost<kKind>, 2, kCameraSize, kAxis, kPoseSize,
                                          kWarpSize>
            cost(new CornerCost<kKind>{&base.channels[0], point, *wanted, s, 1.0});
        const double* blocks[] = {camera.data(), axis, pose.data(), warp.data()};
        double residual[2];
        using Rows = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
        Rows by[4] = {Rows(2, 12), Rows(2, kAxis), Rows(2, 6), Rows(2, 2)};
        double* jacobians[] = {by[0].data(), by[1].data(), by[2].data(), by[3].data()};
        ASSERT_TRUE(cost.Evaluate(blocks, residual, jacobians));
        EXPECT_LT(std::hypot(residual[0], residual[1]), 1e-9);  // px, rounding
        const int sizes[] = {12, kAxis, 6, 2};
        for (int b = 0; b < 4; ++b)
            for (int i = 0; i < sizes[b]; ++i) {
                Eigen::VectorXd block = Eigen::Map<const Eigen::VectorXd>(blocks[b], sizes[b]);
                const double* changed[] = {blocks[0], blocks[1], blocks[2], blocks[3]};
                changed[b] = block.data();
                const double h = 1e-6;
                double after[2], before[2];
                block[i] += h;
                cost.Evaluate(changed, after, nullptr);
                block[i] -= 2 * h;
                cost.Evaluate(changed, before, nullptr);
                for (int k = 0; k < 2; ++k) {
                    const double slope = (after[k] - before[k]) / (2 * h);
                    EXPECT_NEAR(by[b](k, i), slope, 1e-5 * std::abs(slope) + 1e-5)
                        << name_of(kKind) << " block " << b << " entry " << i;
                }
            }
    }
}

TEST(ScannerCost, CornersAgreeWithCoreAndCentralDifferences) {
    compare_corners<MachineKind::rail>();
    compare_corners<MachineKind::turntable>();
}

TEST(ScannerCost, AgreesWithCoreAndCentralDifferences) {
    compare_with_core<MachineKind::swept>();
    compare_with_core<MachineKind::rail>();
    compare_with_core<MachineKind::turntable>();
}

}  // namespace
}  // namespace stria

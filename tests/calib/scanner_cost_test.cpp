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
        const Eigen::Matrix<double, kCameraSize, 1> camera = camera_block(base.channels[0].camera);
        const double s = (kKind == MachineKind::rail ? 50 : 0.1) * unit(rng);
        const Eigen::Vector2d pixel(640 + 200 * unit(rng), 512 + 150 * unit(rng));

        Eigen::VectorXd delta = Eigen::VectorXd::Zero(9 + kSheetSize + kAxis + 1);
        for (int i = 0; i < kSheetSize; ++i) delta[9 + i] = sheet[i];
        for (int i = 0; i < kAxis; ++i) delta[9 + kSheetSize + i] = axis[i];
        const Channel moved = perturbed(base, delta).channels[0];
        const double wanted = distance_on_board(moved, some_pose(), pixel, s);

        const StripeCost<kKind> cost(&base.channels[0], std::make_shared<LightAt<kKind>>(), pixel,
                                     s, 1.0);
        const double* blocks[] = {camera.data(), sheet, axis, pose.data()};
        double residual = 0;
        Eigen::VectorXd by[4] = {Eigen::VectorXd(12), Eigen::VectorXd(5), Eigen::VectorXd(kAxis),
                                 Eigen::VectorXd(6)};
        double* jacobians[] = {by[0].data(), by[1].data(), by[2].data(), by[3].data()};
        ASSERT_TRUE(cost.Evaluate(blocks, &residual, jacobians));
        // mm, up to the side the normal points to; rounding at 500 mm
        EXPECT_NEAR(std::abs(residual), std::abs(wanted), 1e-9) << name_of(kKind);

        const int sizes[] = {12, 5, kAxis, 6};
        for (int b = 0; b < 4; ++b)
            for (int i = 0; i < sizes[b]; ++i) {
                Eigen::VectorXd block = Eigen::Map<const Eigen::VectorXd>(blocks[b], sizes[b]);
                const double h = 1e-6;
                const double* changed[] = {blocks[0], blocks[1], blocks[2], blocks[3]};
                changed[b] = block.data();
                double after = 0, before = 0;
                block[i] += h;
                cost.Evaluate(changed, &after, nullptr);
                block[i] -= 2 * h;
                cost.Evaluate(changed, &before, nullptr);
                const double slope = (after - before) / (2 * h);
                EXPECT_NEAR(by[b][i], slope, 1e-5 * std::abs(slope) + 1e-5)
                    << name_of(kKind) << " block " << b << " entry " << i;
            }
    }
}

TEST(ScannerCost, AgreesWithCoreAndCentralDifferences) {
    compare_with_core<MachineKind::swept>();
    compare_with_core<MachineKind::rail>();
    compare_with_core<MachineKind::turntable>();
}

}  // namespace
}  // namespace stria

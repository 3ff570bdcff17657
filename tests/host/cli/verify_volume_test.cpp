#include "tests/host/cli/verify_volume.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/verify/probing.h"

namespace stria::test_support {
namespace {

using Eigen::Vector3d;

/// One position through a camera of a third of the pixels; the whole procedure is in the long test.
TEST(VerifyVolume, OneSphereIsMeasuredAsItsNoiseAllows) {
    const RangeImage image = scan_volume(volume_scene(0.35), {volume_sphere({5, 4, -410}, 15)}, 3);
    Artefact artefact;
    artefact.diameters = {{30, 0}};
    std::mt19937 rng(1);
    const ProbingPosition position = probe_sphere(scan_points(image), artefact, {}, rng);
    const FormFigures& form = position.sphere.form;
    std::printf(
        "PS %.2f um (fit %.2f), PF %.2f um, expected %.2f, predicted noise %.2f, ratio %.3f, "
        "%zu points\n",
        1000 * position.size_mm, 1000 * position.sphere.diameter_sigma_mm, 1000 * form.form_mm,
        1000 * form.expected_form_mm, 1000 * form.predicted_sigma_mm, form.sigma_ratio,
        form.points_used);
    EXPECT_GT(form.points_used, 1500U);
    EXPECT_NEAR(form.sigma_ratio, 1, 0.15);       // 0.02: one standard deviation for 3900 points
    EXPECT_LT(std::abs(position.size_mm), 0.02);  // mm: what a pixel averages over, 0.2 mm (one
                                                  // sigma), sags by 7 x 0.2^2 / 15 at the most
    EXPECT_LT(form.form_mm, 1.15 * form.expected_form_mm);
}

/// Whether a sphere lies, at least in part, behind another for a viewer there.
bool hides(const Vector3d& eye, const Vector3d& a, const Vector3d& b, double radius_mm) {
    const Vector3d to_a = a - eye, to_b = b - eye;
    const double apart = std::acos(to_a.normalized().dot(to_b.normalized()));
    return apart < std::asin(radius_mm / to_a.norm()) + std::asin(radius_mm / to_b.norm());
}

TEST(VerifyVolume, NoSphereOfABarHidesTheOther) {
    // Camera, and the place of the mirror that light seems to come from (y and z turned about).
    const Vector3d mirror = volume_scene(1).channel.axis.mirror.point;
    const auto bars = bar_positions(100);
    EXPECT_EQ(bars.size(), 7U);
    for (const auto& [first, second] : bars) {
        EXPECT_NEAR((second - first).norm(), 100, 1e-9);
        EXPECT_FALSE(hides(Vector3d::Zero(), first, second, 15)) << first.transpose();
        EXPECT_FALSE(hides({mirror.x(), -mirror.y(), -mirror.z()}, first, second, 15))
            << first.transpose();
    }
}

}  // namespace
}  // namespace stria::test_support

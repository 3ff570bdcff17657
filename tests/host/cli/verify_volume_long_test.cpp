#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/verify/beam.h"
#include "host/verify/flatness.h"
#include "host/verify/probing.h"
#include "host/verify/travel.h"
#include "tests/host/cli/verify_volume.h"

/// The acceptance figures asked of a simulated scanner in a volume of 300 mm: probing size <= 10
/// um, form <= 6.5 x the predicted noise with at most 1e5 points, sphere spacing <= 15 um.
namespace stria::test_support {
namespace {

constexpr double kDiameter = 30;

void print(const std::string& name, const FormFigures& f) {
    std::printf(
        "%-12s form %6.2f um, expected %6.2f, d95 %6.2f, noise %5.2f, predicted %5.2f, "
        "ratio %.3f, form/predicted %.2f, %zu points, %zu rejected",
        name.c_str(), 1000 * f.form_mm, 1000 * f.expected_form_mm, 1000 * f.d95_mm,
        1000 * f.sigma_mm, 1000 * f.predicted_sigma_mm, f.sigma_ratio, f.form_ratio, f.points_used,
        f.rejected);
}

TEST(VerifyVolumeLong, ProbingKeepsItsTargets) {
    Artefact artefact;
    artefact.diameters = {{kDiameter, 0}};
    std::mt19937 rng(1);
    unsigned seed = 100;
    for (const Eigen::Vector3d& place : sphere_positions()) {
        const std::string name = "sphere" + std::to_string(seed - 99);
        const RangeImage image =
            scan_volume(volume_scene(1), {volume_sphere(place, kDiameter / 2)}, seed++);
        keep_scan(name, image);
        const ProbingPosition position = probe_sphere(scan_points(image), artefact, {}, rng);
        const MeasuredSphere& sphere = position.sphere;
        print(name, sphere.form);
        std::printf(", size %6.2f um (fit %.2f), centre off %.2f um\n", 1000 * position.size_mm,
                    1000 * sphere.diameter_sigma_mm, 1000 * (sphere.centre - place).norm());
        std::fflush(stdout);
        EXPECT_LE(std::abs(position.size_mm), 0.010) << name;
        EXPECT_LE(sphere.form.form_ratio, 6.5) << name;
        EXPECT_LE(sphere.form.points_used, 100000U);
    }
}

TEST(VerifyVolumeLong, SphereSpacingKeepsItsTarget) {
    Artefact artefact;
    artefact.diameters = {{kDiameter, 0}, {kDiameter, 0}};
    artefact.lengths = {{100, 0}};
    std::mt19937 rng(2);
    unsigned seed = 200;
    for (const auto& [first, second] : bar_positions(artefact.lengths[0].mm)) {
        const std::string name = "bar" + std::to_string(seed - 199);
        const RangeImage image = scan_volume(
            volume_scene(1),
            {volume_sphere(first, kDiameter / 2), volume_sphere(second, kDiameter / 2)}, seed++);
        keep_scan(name, image);
        const MeasuredBeam beam = measure_beam(scan_points(image), artefact, {}, rng);
        const BeamLength spacing = centre_distance(beam, artefact, 0, 1);
        const BeamLength over = length_over(beam, artefact, 0, 1);
        std::printf("%-12s SD %6.2f um (U %.2f), length over both %6.2f um (U %.2f)\n",
                    name.c_str(), 1000 * spacing.error_mm(), 1000 * spacing.expanded_mm,
                    1000 * over.error_mm(), 1000 * over.expanded_mm);
        std::fflush(stdout);
        EXPECT_LE(std::abs(spacing.error_mm()), 0.015) << name;
    }
}

TEST(VerifyVolumeLong, FlatnessIsWhatNoiseShows) {
    std::mt19937 rng(3);
    unsigned seed = 300;
    for (const Rigid3& pose : plate_positions()) {
        const std::string name = "plane" + std::to_string(seed - 299);
        const RangeImage image =
            scan_volume(volume_scene(0.5), {volume_plate(pose, {150, 60})}, seed++);
        keep_scan(name, image);
        const MeasuredPlane plane =
            measure_plane(scan_points(image), {.size_mm = {150, 60}, .margin_mm = 2}, rng);
        print(name, plane.form);
        std::printf("\n");
        std::fflush(stdout);
        EXPECT_LE(plane.form.form_mm, 1.3 * plane.form.expected_form_mm) << name;
    }
}

/// A plate that travels along its normal, from the near to the far end of the volume and back.
TEST(VerifyVolumeLong, ProfileIsLinearAndRepeats) {
    const Eigen::Matrix3d turn = rotation_from_vector({0.15, 0.1, 0});
    const std::vector<double> travelled = {-70, -35, 0, 35, 70, 35, 0, -35, -70};
    std::mt19937 rng(4);
    std::vector<MeasuredPlane> planes;
    for (std::size_t i = 0; i < travelled.size(); ++i) {
        const Rigid3 pose{turn,
                          turn * Eigen::Vector3d(0, 0, travelled[i]) + Eigen::Vector3d(0, 0, -420)};
        const RangeImage image = scan_volume(volume_scene(0.4), {volume_plate(pose, {60, 40})},
                                             static_cast<unsigned>(400 + i));
        keep_scan("travel" + std::to_string(i + 1), image);
        planes.push_back(
            measure_plane(scan_points(image), {.size_mm = {60, 40}, .margin_mm = 2}, rng));
    }
    const TravelFigures figures = travel_figures(planes, travelled);
    for (const TravelStep& step : figures.steps)
        std::printf("travelled %4.0f mm: error %6.2f um, a point %.2f um, the plane %.2f um\n",
                    step.true_mm, 1000 * step.error_mm, 1000 * step.point_sigma_mm,
                    1000 * step.plane_sigma_mm);
    std::printf("linearity %.2f um, repeatability %.2f um, scale %.1f um a metre\n",
                1000 * figures.linearity_mm, 1000 * figures.repeatability_mm,
                1e6 * figures.scale_error);
    EXPECT_LE(figures.linearity_mm, 0.002);      // mm: what the log's noise leaves of 4 um a row
    EXPECT_LE(figures.repeatability_mm, 0.001);  // mm, one sigma
}

}  // namespace
}  // namespace stria::test_support

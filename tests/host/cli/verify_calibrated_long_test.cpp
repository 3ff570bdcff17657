#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "calib/scanner_calibration.h"
#include "host/cli/calibration_views.h"
#include "host/cli/recording_range.h"
#include "host/local/local_scanner.h"
#include "host/verify/beam.h"
#include "tests/host/cli/verify_volume.h"
#include "tests/support/machine_scenes.h"

/// The whole way: a swept scanner calibrates itself on its simulated board, then scans ball bars,
/// and is verified on them with that calibration.
namespace stria::test_support {
namespace {

using Eigen::Vector3d;

ScannerModel calibrated(const MachineScenes& scenes) {
    LocalScanner device(scenes.board_scene);
    std::vector<CalibrationView> views;
    ScannerModel nominal;
    for (int view = 0; view < view_count(scenes.board_scene); ++view) {
        const std::string name = "view " + std::to_string(view);
        device.scanner().set_view(view);
        const RecordingContents contents = device.run(scenes.board_plan);
        nominal = nominal_model_of(contents, name);
        views.push_back(calibration_view_of(contents, name));
    }
    const ScannerCalibration calibration = calibrate_scanner(views, scenes.board, nominal);
    EXPECT_TRUE(calibration.converged);
    return calibration.model;
}

TEST(VerifyCalibratedLong, ASweptScannerMeasuresBarsWithItsOwnCalibration) {
    const MachineScenes scenes = machine_scenes(MachineKind::swept, 4);
    const ScannerModel model = calibrated(scenes);
    Artefact artefact;
    artefact.diameters = {{40, 0}, {40, 0}};
    artefact.lengths = {{100, 0}};
    std::mt19937 rng(1);
    const std::vector<Vector3d> ways = {{1, 0.1, 0}, {0.2, 1, 0.1}, {0.6, 0.4, 0.6}};
    for (std::size_t i = 0; i < ways.size(); ++i) {
        Scene scene = scenes.sphere_scene;
        const Vector3d middle(0, 0, -450), half = 50 * ways[i].normalized();
        scene.objects = {volume_sphere(middle - half, 20), volume_sphere(middle + half, 20)};
        scene.objects[1].name = "second";
        LocalScanner device(scene);
        ScanPlan plan = scenes.sphere_plan;
        plan.step = 3e-4;
        plan.max_emission_s = 600;
        const RangeImage image = range_of(device.run(plan), model, "bar").image;
        keep_scan("calibrated" + std::to_string(i + 1), image);
        const MeasuredBeam beam = measure_beam(scan_points(image), artefact, {}, rng);
        const BeamLength spacing = centre_distance(beam, artefact, 0, 1);
        std::printf("calibrated: SD %.2f um (U of the fits %.2f)", 1000 * spacing.error_mm(),
                    1000 * spacing.expanded_mm);
        for (const MeasuredSphere& sphere : beam.free) {
            const FormFigures& f = sphere.form;
            std::printf(
                "; size %.2f um, form %.2f um, expected %.2f, ratio %.3f, systematic %.2f um",
                1000 * (sphere.diameter_mm - 40), 1000 * f.form_mm, 1000 * f.expected_form_mm,
                f.sigma_ratio, 1000 * f.predicted_systematic_mm);
        }
        std::printf("\n");
        EXPECT_LE(std::abs(spacing.error_mm()), 0.015);
    }
}

}  // namespace
}  // namespace stria::test_support

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "calib/scanner_calibration.h"
#include "firmware/core/median.h"
#include "host/cli/calibration_views.h"
#include "host/cli/recording_range.h"
#include "host/geometry/align.h"
#include "host/geometry/fit.h"
#include "host/geometry/range_grid.h"
#include "host/io/image_io.h"
#include "host/io/whole_file.h"
#include "host/local/open_device.h"
#include "sim/scene.h"
#include "tests/support/machine_scenes.h"

/// Each kind of machine from nothing to a measured sphere: calibrated on its own simulated board,
/// then a sphere of radius 25 mm scanned with that calibration.
namespace stria {
namespace {

using Eigen::Vector3d;
using test_support::kSphereRadiusMm;
using test_support::machine_scenes;
using test_support::MachineScenes;

RecordingContents run_view(DeviceClient& device, const ScanPlan& plan, int view) {
    device.set_feature("SceneView", FeatureValue(std::int64_t{view}));
    return device.run(plan);
}

class Machines : public testing::TestWithParam<MachineKind> {
  protected:
    void SetUp() override {
        folder_ = std::filesystem::temp_directory_path() /
                  ("stria-machines-" + std::string(name_of(GetParam())));
        std::filesystem::create_directories(folder_);
        scenes_ = machine_scenes(GetParam(), 4);
        write_png((folder_ / "board.png").string(),
                  *scenes_.board_scene.objects.front().texture_image);
        write_whole_file((folder_ / "board.toml").string(), format_scene(scenes_.board_scene));
        write_whole_file((folder_ / "sphere.toml").string(), format_scene(scenes_.sphere_scene));
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    std::unique_ptr<DeviceClient> open(const char* scene) const {
        OpenOptions options;
        options.seed = 9;
        options.threads = 2;
        return open_device("sim:" + (folder_ / scene).string(), options);
    }

    ScannerCalibration calibrate() const {
        auto device = open("board.toml");
        std::vector<CalibrationView> views;
        ScannerModel nominal;
        const int count = static_cast<int>(scenes_.board_scene.views.size());
        for (int view = 0; view < count; ++view) {
            const RecordingContents contents = run_view(*device, scenes_.board_plan, view);
            nominal = nominal_model_of(contents, "view " + std::to_string(view));
            views.push_back(calibration_view_of(contents, "view " + std::to_string(view)));
        }
        return calibrate_scanner(views, scenes_.board, nominal);
    }

    std::filesystem::path folder_;
    MachineScenes scenes_;
};

/// Points both models make of the same pixels and positions, inside the space round the middle.
void pair_points(const ScannerModel& model, const Channel& truth, const ScanPlan& plan,
                 std::vector<Vector3d>& ours, std::vector<Vector3d>& true_ones) {
    const bool sweeps = truth.axis.kind == MachineKind::swept;
    for (int v = 16; v < truth.camera.height; v += 32)
        for (int u = 16; u < truth.camera.width; u += 16)
            for (int k = 0; k <= 16; ++k) {
                const double s = plan.from + (plan.to - plan.from) * k / 16;
                const auto p = triangulate(model.channels[0], Eigen::Vector2d(u, v), s);
                const auto q = triangulate(truth, Eigen::Vector2d(u, v), s);
                if (!p || !q) continue;
                const Vector3d in_camera = scan_from_camera(truth, s).inverse() * q->point_in_scan;
                if (in_camera.z() < (sweeps ? 400 : 410) || in_camera.z() > (sweeps ? 500 : 490))
                    continue;
                ours.push_back(p->point_in_scan);
                true_ones.push_back(q->point_in_scan);
            }
}

TEST_P(Machines, CalibrateAndMeasureASphere) {
    const ScannerCalibration calibration = calibrate();
    ASSERT_TRUE(calibration.converged);
    const Channel& truth = scenes_.board_scene.channel;

    std::vector<Vector3d> ours, true_ones;
    pair_points(calibration.model, truth, scenes_.board_plan, ours, true_ones);
    ASSERT_GT(ours.size(), 200U);
    const Rigid3 motion = align_points(ours, true_ones);
    double squares = 0;
    Vector3d low = true_ones.front(), high = low;
    for (std::size_t i = 0; i < ours.size(); ++i) {
        squares += (motion * ours[i] - true_ones[i]).squaredNorm();
        low = low.cwiseMin(true_ones[i]);
        high = high.cwiseMax(true_ones[i]);
    }
    const double rms_mm = std::sqrt(squares / static_cast<double>(ours.size()));
    const double diagonal_mm = (high - low).norm();

    auto device = open("sphere.toml");
    const RecordingContents scan = run_view(*device, scenes_.sphere_plan, 0);
    const RangeResult range = range_of(scan, calibration.model, "sphere");
    const RangeImage& image = range.image;
    const auto border = border_distance(image, range_triangles(image), 4);
    std::vector<Vector3d> points;
    std::vector<std::size_t> cells;
    for (std::size_t i = 0; i < image.cell_count(); ++i)
        if (image.mask[i] && border[i] > 3) {
            points.push_back(image.points[i].position);
            cells.push_back(i);
        }
    ASSERT_GT(points.size(), 3000U);
    const SphereFit sphere = fit_sphere(points);

    std::vector<double> normalised;
    for (std::size_t i : cells) {
        const RangePoint& p = image.points[i];
        const Vector3d out = (p.position - sphere.centre).normalized();
        const Vector3d e = p.error_direction.cast<double>();
        const double along = ((p.position - sphere.centre).norm() - kSphereRadiusMm) / out.dot(e);
        normalised.push_back(along / std::hypot(p.sigma_mm, p.sigma_systematic_mm));
    }
    const double middle = median(normalised);
    for (double& x : normalised) x = std::abs(x - middle);
    const double sigma_ratio = 1.4826 * median(normalised);

    std::printf(
        "%s: calibration %.3f px rms, points %.4f mm rms = %.2e of the diagonal %.0f mm; "
        "sphere of %zu points: radius %+.4f mm, rms %.4f mm, sigma_ratio %.3f\n",
        name_of(GetParam()), calibration.rms_px, rms_mm, rms_mm / diagonal_mm, diagonal_mm,
        points.size(), sphere.radius_mm - kSphereRadiusMm, sphere.rms_mm, sigma_ratio);
    EXPECT_LE(rms_mm, 1e-4 * diagonal_mm);
    EXPECT_NEAR(sphere.radius_mm, kSphereRadiusMm, 0.02);  // mm: the figure to hold
    EXPECT_GE(sigma_ratio, 0.8);
    EXPECT_LE(sigma_ratio, 1.25);
}

INSTANTIATE_TEST_SUITE_P(Kinds, Machines,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& kind) { return std::string(name_of(kind.param)); });

}  // namespace
}  // namespace stria

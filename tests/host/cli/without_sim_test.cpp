#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "calib/scanner_calibration.h"
#include "host/cli/calibration_views.h"
#include "host/cli/recording_range.h"
#include "host/fusion/fuse.h"
#include "host/geometry/align.h"
#include "host/geometry/nearest.h"
#include "host/mesh/compare.h"
#include "host/registration/coarse.h"
#include "host/registration/joint.h"
#include "tests/support/measured_object.h"

/// Calibration, range images, registration and fusion on recordings whose scene is gone, in a
/// program that holds no simulator: nothing here can know the truth but the last comparison, which
/// has the object in closed form.
namespace stria {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

/// Written by record_scans, the fixture of this test.
const fs::path kRecorded = STRIA_RECORDED_SCANS;

std::string recording(const char* folder, std::size_t i) {
    return (kRecorded / folder / (std::to_string(i) + ".stria")).string();
}

std::size_t recordings_in(const char* folder) {
    std::size_t count = 0;
    while (fs::exists(recording(folder, count))) ++count;
    return count;
}

bool is_loaded(const std::string& library) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);)
        if (line.find(library) != std::string::npos) return true;
    return false;
}

ScannerCalibration calibrate(const Board& board) {
    std::vector<CalibrationView> views;
    ScannerModel nominal;
    for (std::size_t i = 0; i < recordings_in("board"); ++i) {
        const RecordingContents contents = load_recording(recording("board", i));
        nominal = nominal_model_of(contents, recording("board", i));
        views.push_back(calibration_view_of(contents, recording("board", i)));
    }
    return calibrate_scanner(views, board, nominal);
}

/// Iterated closest points of every 10th vertex: from some hundredths of a mm off to the best fit.
Rigid3 best_motion(const TriMesh& mesh, const TriMesh& truth, Rigid3 truth_from_mesh) {
    const SurfaceTree tree(truth);
    for (int round = 0; round < 20; ++round) {
        std::vector<Vector3d> from, to;
        for (std::size_t i = 0; i < mesh.positions.size(); i += 10) {
            const auto hit = tree.nearest(truth_from_mesh * mesh.positions[i]);
            if (!hit || hit->distance_mm > 1) continue;
            from.push_back(mesh.positions[i]);
            to.push_back(hit->point);
        }
        truth_from_mesh = align_points(from, to);
    }
    return truth_from_mesh;
}

TEST(WithoutSim, RecordingsBecomeAMeasuredMesh) {
    EXPECT_FALSE(is_loaded("libembree"));
    ASSERT_FALSE(fs::exists(kRecorded / "scenes"));
    ASSERT_GT(recordings_in("board"), 5U);
    ASSERT_EQ(recordings_in("object"),
              static_cast<std::size_t>(test_support::kMeasuredObjectViews));

    const ScannerCalibration calibration =
        calibrate(parse_board("charuco:12x9:14:10:DICT_5X5_250"));
    ASSERT_TRUE(calibration.converged);

    std::vector<RangeImage> scans;
    std::vector<ScanSurface> surfaces;
    for (std::size_t i = 0; i < recordings_in("object"); ++i) {
        const std::string name = recording("object", i);
        scans.push_back(range_of(load_recording(name), calibration.model, name).image);
        surfaces.push_back(prepare_surface(scans.back()));
    }
    const CoarseResult coarse = place_scans(surfaces);
    std::vector<ScanPose> poses(scans.size());
    for (std::size_t i = 0; i < scans.size(); ++i) {
        ASSERT_TRUE(coarse.scans[i].placed) << i << ": " << coarse.scans[i].reason;
        poses[i].world_from_scan = coarse.scans[i].world_from_scan;
    }
    const JointResult joint = register_jointly(surfaces, poses);
    ASSERT_TRUE(joint.converged) << joint.reason;

    std::vector<FuseScan> placed;
    for (std::size_t i = 0; i < scans.size(); ++i)
        placed.push_back({&scans[i], joint.scans[i].world_from_scan});
    FuseOptions options;
    options.voxel_mm = 0.6;
    FusedVolume fused = fuse_volume(placed, options);
    TriMesh mesh = fused_surface(fused, options);

    const TriMesh truth = test_support::measured_object();
    const Rigid3 start = test_support::measured_object_poses().front().inverse() *
                         joint.scans.front().world_from_scan.inverse();
    const Rigid3 truth_from_mesh = best_motion(mesh, truth, start);
    for (Vector3d& p : mesh.positions) p = truth_from_mesh * p;
    const DistanceFigures error = compare_meshes(mesh, truth).a_to_b;
    std::printf(
        "calibration %.3f px; overlap %.4f mm; mesh of %zu vertices: rms %.4f, p99 %.4f, "
        "max %.3f mm\n",
        calibration.rms_px, joint.overlap_rms_mm, mesh.positions.size(), error.rms_mm, error.p99_mm,
        error.max_mm);
    EXPECT_GT(mesh.positions.size(), 50000U);
    EXPECT_LE(error.rms_mm, 0.05);  // mm: the figures to hold of the demo
    EXPECT_LE(error.p99_mm, 0.2);
}

}  // namespace
}  // namespace stria

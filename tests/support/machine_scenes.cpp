#include "tests/support/machine_scenes.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "calib/board_drawing.h"
#include "firmware/core/angle.h"
#include "tests/support/synthetic_scanner.h"

namespace stria::test_support {
namespace {

using Eigen::Vector3d;
constexpr double kPxPerMm = 12;
constexpr double kMarginMm = 5;

SceneObject plate(const Board& board) {
    SceneObject object;
    object.name = "board";
    object.shape = SceneShape::plane;
    object.size_mm = picture_size_mm(board, kPxPerMm, kMarginMm);
    object.corner_mm = picture_corner_mm(board, kMarginMm);
    object.albedo = 0.85;
    object.texture = "board.png";
    object.texture_size_mm = object.size_mm;
    object.texture_image =
        std::make_shared<const GreyImage>(draw_board(board, kPxPerMm, kMarginMm));
    return object;
}

/// Placements of a board about a middle: tilted all ways, nearer and farther. `upright` turns the
/// board (x right, y down, z away) into the world for a viewer in front.
std::vector<SceneView> placements(int count, const Board& board, const Vector3d& middle,
                                  const Eigen::Matrix3d& upright, double depth_mm,
                                  std::mt19937& rng) {
    std::uniform_real_distribution<double> unit(-1, 1);
    const Eigen::Vector2d size = pattern_size_mm(board);
    const Vector3d to_middle(0.5 * size.x(), 0.5 * size.y(), 0);
    std::vector<SceneView> views;
    for (int i = 0; i < count; ++i) {
        const double towards = 6 * std::numbers::pi * (i + 0.3 * unit(rng)) / count;
        const double tilt = (22 + 10 * std::abs(unit(rng))) * kDegree;
        const Vector3d about(std::cos(towards), std::sin(towards), 0);  // board frame
        const Eigen::Matrix3d turn = upright * rotation_from_vector(tilt * about) *
                                     rotation_from_vector({0, 0, 12 * kDegree * unit(rng)});
        const Vector3d away = upright * Vector3d::UnitZ();
        const double depth = depth_mm * (count > 1 ? 2.0 * i / (count - 1) - 1 : 0);
        SceneView view;
        view.name = "board " + std::to_string(i + 1);
        view.poses.push_back({"board", {turn, middle + depth * away - turn * to_middle}});
        views.push_back(std::move(view));
    }
    return views;
}

Scene empty_scene(const ScannerModel& scanner, unsigned seed) {
    Scene scene;
    scene.seed = seed;
    scene.channel = scanner.channels.front();
    scene.sensor.full_well_e = 4300;
    scene.sensor.gain_e_per_dn = 4300.0 / 255.0;
    scene.sensor.read_noise_e = 8;
    scene.sensor.exposure_us = 2000;
    scene.sensor.min_frame_period_us = 4000;
    scene.laser_power_mw = 9;
    scene.ambient_level = 0.05;
    return scene;
}

}  // namespace

MachineScenes machine_scenes(MachineKind kind, unsigned seed) {
    std::mt19937 rng(seed);
    MachineScenes made;
    made.board = parse_board(kind == MachineKind::turntable ? "charuco:9x7:11:8:DICT_5X5_250"
                                                            : "charuco:12x9:14:10:DICT_5X5_250");
    ScannerModel scanner = kind == MachineKind::swept  ? swept_scanner()
                           : kind == MachineKind::rail ? rail_scanner()
                                                       : turntable_scanner();
    Scene scene = empty_scene(scanner, seed);
    Eigen::Matrix3d upright = Vector3d(1, -1, -1).asDiagonal();
    Vector3d middle(0, 0, -450);
    ScanPlan& plan = made.board_plan;
    plan.mode = StripeMode::spatial;
    plan.off_exposure_us = 30000;
    switch (kind) {
        case MachineKind::swept:
            scene.axis = {.min = -0.2, .max = 0.2, .max_speed = 5, .sigma = 2e-6};
            plan.mode = StripeMode::spacetime;
            plan.from = -0.12;
            plan.to = 0.12;
            plan.step = 6e-4;
            plan.off_frames = 1;
            break;
        case MachineKind::rail:
            scene.axis = {.min = -150, .max = 150, .max_speed = 2000, .sigma = 0.002};
            plan.from = -75;
            plan.to = 75;
            plan.step = 3;
            plan.off_frames = 5;
            break;
        case MachineKind::turntable:
            scene.axis = {.min = -7, .max = 7, .max_speed = 50, .sigma = 2e-5};
            plan.from = -40 * kDegree;
            plan.to = 40 * kDegree;
            plan.step = 2 * kDegree;
            plan.off_frames = 7;
            // the camera stands on the table's -y and looks along +y; z is up
            upright << 1, 0, 0, 0, 0, 1, 0, -1, 0;
            middle = Vector3d(0, 0, 0);
            break;
    }
    made.board_scene = scene;
    made.board_scene.objects.push_back(plate(made.board));
    made.board_scene.views = placements(kind == MachineKind::turntable ? 10 : 9, made.board, middle,
                                        upright, kind == MachineKind::turntable ? 25 : 45, rng);

    made.sphere_scene = scene;
    SceneObject sphere;
    sphere.name = "sphere";
    sphere.shape = SceneShape::sphere;
    sphere.radius_mm = kSphereRadiusMm;
    sphere.albedo = 0.8;
    sphere.world_from_object.translation =
        middle + (kind == MachineKind::turntable ? Vector3d(12, 5, 3) : Vector3d(4, -6, 10));
    made.sphere_scene.objects.push_back(sphere);
    made.sphere_plan = plan;
    made.sphere_plan.off_frames = 0;
    if (kind == MachineKind::rail) made.sphere_plan.step = 0.5;
    if (kind == MachineKind::turntable) {
        made.sphere_plan.from = -180 * kDegree;
        made.sphere_plan.to = 180 * kDegree;
        made.sphere_plan.step = 1 * kDegree;
    }
    return made;
}

}  // namespace stria::test_support

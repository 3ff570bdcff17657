#include "host/cli/demo/demo_scene.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "calib/board_drawing.h"
#include "firmware/core/angle.h"
#include "host/cli/demo/sculpture.h"
#include "host/io/image_io.h"
#include "host/io/mesh_io.h"
#include "host/io/whole_file.h"
#include "sim/scene.h"

namespace stria {
namespace {

using Eigen::Vector3d;
constexpr double kDistanceMm = 460;         // camera to the middle of the object
constexpr double kMirrorRange_rad = 0.128;  // the beam then covers the camera's field
constexpr double kBeamSigmaMm = 0.6;
constexpr double kBoardPxPerMm = 12;

/// The design of the scanner: camera at the origin, mirror 180 mm to its right, laser beside it.
Channel scanner_design(bool quick) {
    Channel channel;
    CameraModel& camera = channel.camera;
    camera.kind = LensKind::brown5;
    camera.width = quick ? 480 : 768;
    camera.height = quick ? 405 : 640;
    const double pitch_mm = quick ? 0.427 : 0.27;
    camera.fx = camera.fy = kDistanceMm / pitch_mm;
    camera.cx = 0.5 * (camera.width - 1);
    camera.cy = 0.5 * (camera.height - 1);

    const Vector3d pivot(180, 0, 20), target(0, 0, kDistanceMm - 10), incoming(-1, 0, 0);
    LaserSheet& sheet = channel.sheet;
    sheet.apex = pivot - 80 * incoming;
    sheet.central_ray = incoming;
    sheet.normal = Vector3d::UnitZ();
    sheet.offset_mm = pivot.z();
    sheet.fan_rad = 0.6;
    sheet.waist_sigma_mm = kBeamSigmaMm;
    sheet.waist_at_mm = 80 + (target - pivot).norm();
    sheet.wavelength_nm = 650;

    channel.axis.kind = MachineKind::swept;
    MirrorAxis& mirror = channel.axis.mirror;
    mirror.direction = Vector3d::UnitY();
    mirror.point = {pivot.x(), 0, pivot.z()};
    mirror.normal0 = ((target - pivot).normalized() - incoming).normalized();
    return channel;
}

/// One built scanner: the design with lens distortion and the seed's assembly errors.
Channel built_scanner(bool quick, std::mt19937& rng) {
    Channel channel = scanner_design(quick);
    std::uniform_real_distribution<double> unit(-1, 1);
    CameraModel& camera = channel.camera;
    camera.fx *= 1 + 0.01 * unit(rng);
    camera.fy = camera.fx * (1 + 0.001 * unit(rng));
    camera.cx += 6 * unit(rng);
    camera.cy += 6 * unit(rng);
    camera.distortion = {
        -0.10 + 0.02 * unit(rng), 0.15 * unit(rng), 5e-4 * unit(rng), 5e-4 * unit(rng), 0, 0, 0, 0};
    MirrorAxis& mirror = channel.axis.mirror;
    const auto turn = [&] {
        return Vector3d(0.006 * unit(rng), 0.006 * unit(rng), 0.006 * unit(rng));
    };
    mirror.direction = (rotation_from_vector(turn()) * mirror.direction).normalized();
    mirror.normal0 = (rotation_from_vector(turn()) * mirror.normal0).normalized();
    mirror.offset_mm = 0.4 * unit(rng);
    mirror.point += Vector3d(unit(rng), 0, unit(rng));
    mirror.point -= mirror.point.dot(mirror.direction) * mirror.direction;
    mirror.g2 = 0.01 * unit(rng);
    channel.sheet.normal = (rotation_from_vector(turn()) * channel.sheet.normal).normalized();
    channel.sheet.offset_mm = channel.sheet.normal.dot(channel.sheet.apex);
    channel.sheet = normalised(channel.sheet);
    return channel;
}

Scene empty_scene(const Channel& channel, unsigned seed) {
    Scene scene;
    scene.seed = seed;
    scene.channel = channel;
    scene.sensor.full_well_e = 4300;  // peak SNR sqrt(0.85 x 4300) = 60
    scene.sensor.read_noise_e = 8;
    scene.sensor.gain_e_per_dn = 4300.0 / 255.0;
    scene.sensor.bits = 8;
    scene.sensor.black_dn = 4;  // so that dark noise is not cut off
    scene.sensor.exposure_us = 2000;
    scene.sensor.min_frame_period_us = 4000;
    scene.laser_power_mw = 9;  // 0.85 of full scale on the light paint
    scene.axis = {.min = -0.2, .max = 0.2, .max_speed = 5, .sigma = 2e-6, .log_period_us = 500};
    scene.ambient_level = 0.05;
    return scene;
}

/// Turns `facing` (object frame) towards the camera (+z of the world) with y roughly up.
Eigen::Matrix3d facing_camera(const Vector3d& facing, double roll_rad) {
    const Vector3d z = facing.normalized();
    const Vector3d up = std::abs(z.y()) > 0.9 ? Vector3d::UnitZ() : Vector3d::UnitY();
    const Vector3d x = up.cross(z).normalized();
    Eigen::Matrix3d object_from_view;
    object_from_view << x, z.cross(x), z;
    return rotation_from_vector({0, 0, roll_rad}) * object_from_view.transpose();
}

/// Directions from which the object is seen: a ring, alternating above and below, then into the
/// cup, and obliquely from beneath, where the plinth's flat bottom alone would fit anywhere.
std::vector<Vector3d> view_directions(int count) {
    std::vector<Vector3d> directions;
    const int ring = count - 2;
    for (int i = 0; i < ring; ++i) {
        const double azimuth = 2 * std::numbers::pi * i / ring;
        const double height = (i % 2 == 0 ? 28 : -18) * kDegree;
        directions.emplace_back(std::cos(height) * std::sin(azimuth), std::sin(height),
                                std::cos(height) * std::cos(azimuth));
    }
    directions.emplace_back(0.3, 1.0, 0.45);
    directions.emplace_back(-0.35, -0.6, 0.75);
    return directions;
}

std::vector<SceneView> object_views(int count, std::mt19937& rng) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<SceneView> views;
    for (const Vector3d& direction : view_directions(count)) {
        const Eigen::Matrix3d jitter =
            rotation_from_vector(6 * kDegree * Vector3d(unit(rng), unit(rng), unit(rng)));
        const double roll_rad = std::numbers::pi * unit(rng) * 0.15;
        const Vector3d at =
            Vector3d(0, 0, -kDistanceMm) + Vector3d(3 * unit(rng), 3 * unit(rng), 8 * unit(rng));
        SceneView view;
        view.name = "placement " + std::to_string(views.size() + 1);
        view.poses.push_back({"sculpture", {jitter * facing_camera(direction, roll_rad), at}});
        views.push_back(std::move(view));
    }
    return views;
}

/// Board placements: tilted every way up to 35 degrees, near and far, towards the field's corners.
std::vector<SceneView> board_views(int count, const Eigen::Vector2d& size_mm, std::mt19937& rng) {
    std::uniform_real_distribution<double> unit(-1, 1);
    Eigen::Matrix3d upright = Eigen::Vector3d(1, -1, -1).asDiagonal();  // board y down, z away
    std::vector<SceneView> views;
    for (int i = 0; i < count; ++i) {
        const double towards = 2 * std::numbers::pi * (i + 0.3 * unit(rng)) / count * 3;
        const double tilt = (i == 0 ? 4 : 24 + 11 * std::abs(unit(rng))) * kDegree;
        const Vector3d about(std::cos(towards), std::sin(towards), 0);
        const Eigen::Matrix3d turn = rotation_from_vector(tilt * about) *
                                     rotation_from_vector({0, 0, 12 * kDegree * unit(rng)}) *
                                     upright;
        const Vector3d centre(32 * unit(rng), 26 * unit(rng),
                              -kDistanceMm + 75.0 * (2.0 * i / std::max(1, count - 1) - 1));
        const Vector3d middle_of_board(0.5 * size_mm.x(), 0.5 * size_mm.y(), 0);
        SceneView view;
        view.name = "board " + std::to_string(i + 1);
        view.poses.push_back({"board", {turn, centre - turn * middle_of_board}});
        views.push_back(std::move(view));
    }
    return views;
}

ScanPlan sweep_plan(bool quick) {
    ScanPlan plan;
    plan.mode = StripeMode::spacetime;
    plan.from = -kMirrorRange_rad;
    plan.to = kMirrorRange_rad;
    plan.step = quick ? 8.0e-4 : 7.0e-4;  // 0.65 mm at the object: about one beam sigma
    return plan;
}

}  // namespace

DemoSetup make_demo_setup(bool quick) {
    DemoSetup setup;
    setup.board = parse_board("charuco:14x11:14:10:DICT_5X5_250");
    setup.board_views = quick ? 8 : 14;
    setup.object_views = 10;
    setup.object_plan = sweep_plan(quick);
    setup.board_plan = sweep_plan(quick);
    setup.board_plan.off_frames = 1;
    setup.board_plan.off_exposure_us =
        30000;  // 15 x the scan's: ambient light alone shows the board
    setup.voxel_mm = quick ? 0.5 : 0.3;
    return setup;
}

void write_demo_scenes(const DemoSetup& setup, const std::string& folder, unsigned seed,
                       bool quick) {
    std::mt19937 rng(seed);
    const Channel scanner = built_scanner(quick, rng);

    Scene board = empty_scene(scanner, seed);
    const Eigen::Vector2d size_mm = pattern_size_mm(setup.board);
    const double margin_mm = 6;
    const GreyImage texture = draw_board(setup.board, kBoardPxPerMm, margin_mm);
    write_png(folder + "/board.png", texture);
    SceneObject plate;
    plate.name = "board";
    plate.shape = SceneShape::plane;
    plate.size_mm = picture_size_mm(setup.board, kBoardPxPerMm, margin_mm);
    plate.corner_mm = picture_corner_mm(setup.board, margin_mm);
    plate.albedo = 0.85;
    plate.texture = "board.png";
    plate.texture_size_mm = plate.size_mm;
    board.objects.push_back(plate);
    board.views = board_views(setup.board_views, size_mm, rng);
    write_whole_file(folder + "/board.toml", format_scene(board));

    Scene object = empty_scene(scanner, seed + 1000003U);
    write_mesh(folder + "/sculpture.ply", merged(make_sculpture()));
    SceneObject sculpture;
    sculpture.name = "sculpture";
    sculpture.shape = SceneShape::mesh;
    sculpture.file = "sculpture.ply";
    sculpture.albedo = 1.0;
    object.objects.push_back(sculpture);
    object.views = object_views(setup.object_views, rng);
    write_whole_file(folder + "/object.toml", format_scene(object));
}

}  // namespace stria

#include "tests/host/cli/verify_volume.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "host/cli/recording_range.h"
#include "host/io/range_io.h"
#include "host/local/local_scanner.h"
#include "sim/scanner_preset.h"

namespace stria::test_support {
namespace {

using Eigen::Vector3d;

constexpr double kMiddleMm = 420;  // depth of the volume's middle

/// Keeps the part of the image that shows the objects, with a border.
void crop_to(CameraModel& camera, const std::vector<SceneObject>& objects) {
    Eigen::Vector2d low(1e9, 1e9), high = -low;
    for (const SceneObject& object : objects) {
        const Vector3d at = object.world_from_object.translation;
        const double reach =
            object.shape == SceneShape::sphere ? object.radius_mm : object.size_mm.norm() / 2;
        const double depth = -at.z(), px = camera.fx * reach / (depth - reach) + 12;
        const Eigen::Vector2d middle(camera.cx + camera.fx * at.x() / depth,
                                     camera.cy - camera.fy * at.y() / depth);
        low = low.cwiseMin(middle - Eigen::Vector2d::Constant(px));
        high = high.cwiseMax(middle + Eigen::Vector2d::Constant(px));
    }
    const int left = std::max(0, static_cast<int>(low.x()));
    const int top = std::max(0, static_cast<int>(low.y()));
    const int right = std::min(camera.width, static_cast<int>(high.x()) + 1);
    const int bottom = std::min(camera.height, static_cast<int>(high.y()) + 1);
    camera.cx -= left;
    camera.cy -= top;
    camera.width = right - left;
    camera.height = bottom - top;
}

ScanPlan plan_over(const SimulatedScanner& scanner, double step) {
    const RangeImage truth = scanner.true_range();
    double from = 1e9, to = -1e9;
    for (std::size_t i = 0; i < truth.cell_count(); ++i) {
        if (truth.mask[i] == 0) continue;
        from = std::min(from, truth.points[i].s);
        to = std::max(to, truth.points[i].s);
    }
    if (!(to > from)) throw std::runtime_error("the artefact is not in view");
    ScanPlan plan;
    plan.mode = StripeMode::spacetime;
    plan.from = from - 10 * step;
    plan.to = to + 10 * step;
    plan.step = step;
    plan.max_emission_s = 600;
    return plan;
}

}  // namespace

Scene volume_scene(double scale) {
    Scene scene = built_in_scene();
    const ScannerPreset preset = scanner_preset("industrial-1.6mp").value();
    scene.sensor = preset.sensor;
    scene.sensor.pixel_um /= scale;
    scene.channel.sheet.wavelength_nm = preset.wavelength_nm;
    CameraModel& camera = scene.channel.camera;
    camera.width = static_cast<int>(1456 * scale);
    camera.height = static_cast<int>(1088 * scale);
    camera.fx = camera.fy = 3200 * scale;
    camera.cx = 0.5 * camera.width + 3;
    camera.cy = 0.5 * camera.height - 4;
    scene.channel.sheet.waist_sigma_mm = 0.12 / scale;
    scene.channel.sheet.waist_at_mm = 500;
    scene.lens.psf_sigma_px = 0.5;
    scene.laser_power_mw = 25;
    scene.axis.log_period_us = 1000;
    scene.objects.clear();
    return scene;
}

SceneObject volume_sphere(const Vector3d& centre, double radius_mm) {
    SceneObject sphere;
    sphere.name = "sphere";
    sphere.shape = SceneShape::sphere;
    sphere.radius_mm = radius_mm;
    sphere.world_from_object.translation = centre;
    sphere.albedo = 0.5;
    return sphere;
}

SceneObject volume_plate(const Rigid3& world_from_object, const Eigen::Vector2d& size_mm) {
    SceneObject plate;
    plate.name = "plate";
    plate.shape = SceneShape::plane;
    plate.size_mm = size_mm;
    plate.corner_mm = -size_mm / 2;
    plate.world_from_object = world_from_object;
    plate.albedo = 0.5;
    return plate;
}

std::vector<Vector3d> sphere_positions() {
    std::vector<Vector3d> places = {{0, 0, -kMiddleMm}, {10, -8, -350}};
    for (const double depth : {345.0, 495.0})
        for (const double x : {-1.0, 1.0})
            for (const double y : {-1.0, 1.0})
                places.emplace_back(0.155 * x * depth, 0.11 * y * depth, -depth);
    return places;
}

std::vector<std::pair<Vector3d, Vector3d>> bar_positions(double length_mm) {
    std::vector<std::pair<Vector3d, Vector3d>> bars;
    const auto add = [&](const Vector3d& middle, const Vector3d& way) {
        const Vector3d half = 0.5 * length_mm * way.normalized();
        bars.emplace_back(middle - half, middle + half);
    };
    const Vector3d middle(0, 0, -kMiddleMm);
    for (const double x : {-1.0, 1.0})  // space diagonals
        for (const double y : {-1.0, 1.0}) add(middle, {1.2 * x, 0.8 * y, 1});
    add({0, 30, -440}, {1, 0, 0});
    add({-35, 0, -440}, {0, 1, 0.25});
    add({20, 0, -430}, {0, 0.45, 1});  // in the sheet's plane one would stand in the other's shadow
    return bars;
}

std::vector<Rigid3> plate_positions() {
    std::vector<Rigid3> poses;
    for (const Vector3d& turn :
         {Vector3d(0, 0, 0), Vector3d(0.5, 0, 0), Vector3d(-0.4, 0.2, 0), Vector3d(0, 0.5, 0),
          Vector3d(0, -0.35, 0), Vector3d(0.2, 0.2, 0.5)}) {
        const auto i = static_cast<double>(poses.size());
        const double depth = kMiddleMm + (poses.size() % 2 == 0 ? 35 : -5);
        poses.push_back({rotation_from_vector(turn), {5 * i - 12.5, 6 * (i - 2.5), -depth}});
    }
    return poses;
}

RangeImage scan_volume(Scene scene, const std::vector<SceneObject>& objects, unsigned seed) {
    crop_to(scene.channel.camera, objects);
    scene.objects = objects;
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        scene.objects[i].name += std::to_string(i + 1);
    OpenOptions options;
    options.seed = seed;
    LocalScanner device(scene, options);
    // A mirror's turn moves the sheet twice as far, 435 mm away at the volume's middle.
    const double step = scene.channel.sheet.waist_sigma_mm / (2 * 435) / 1.4;
    const RecordingContents contents = device.run(plan_over(device.scanner(), step));
    return range_of(contents, device.scanner().truth_model(), "volume").image;
}

void keep_scan(const std::string& name, const RangeImage& image) {
    if (const char* folder = std::getenv("STRIA_VERIFY_OUT"))
        write_range_image(std::string(folder) + "/" + name + ".ply", image);
}

}  // namespace stria::test_support

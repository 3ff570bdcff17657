#include "tests/host/scan/ghost_trials.h"

#include <Eigen/Geometry>
#include <cmath>

#include "firmware/stripe/spacetime.h"
#include "host/core/laser_sheet.h"
#include "sim/scene_geometry.h"
#include "sim/simulated_scanner.h"
#include "tests/sim/sim_sweep.h"

namespace stria::test {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr std::uint16_t kWarnings =
    kPulseOverlapping | kPulseGhostSuspected | kPulseWidthOutOfRange | kPulseTouchesSequenceEnd;

/// The built-in scanner with a beam of 0.6 mm and a picture 120 mm wide at 400 pixels.
Scene scanner(int width, int height) {
    Scene scene = built_in_scene();
    CameraModel& camera = scene.channel.camera;
    camera.width = width;
    camera.height = height;
    camera.fx = camera.fy = 1450;
    camera.cx = (width - 1) / 2.0 + 0.3;
    camera.cy = (height - 1) / 2.0 - 0.2;
    scene.channel.sheet.waist_sigma_mm = 0.6;
    scene.sensor.full_well_e = 10500;
    scene.sensor.gain_e_per_dn = 40;
    scene.ambient_level = 0.02;
    scene.laser_power_mw = 25;
    return scene;
}

SceneObject plate(const std::string& name, const Eigen::Vector2d& low, const Eigen::Vector2d& size,
                  const Eigen::Matrix3d& turn, const Eigen::Vector3d& at) {
    SceneObject object;
    object.name = name;
    object.shape = SceneShape::plane;
    object.corner_mm = low;
    object.size_mm = size;
    object.world_from_object = {turn, at};
    return object;
}

Eigen::Matrix3d about_y(double angle) {
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

/// Distance (mm) of a point from the surface along the rays of its pixel, the least of 5 x 5 over
/// its area: where an edge runs through the pixel either side is true.
double distance_in_pixel(const SceneGeometry& geometry, const Channel& channel, std::size_t cell,
                         const RangePoint& point) {
    const auto width = static_cast<std::size_t>(channel.camera.width);
    const Rigid3 world_from_camera = scan_from_camera(channel, 0);
    const Eigen::Vector3d eye = world_from_camera.translation;
    double least = 1e9;
    for (int j = -2; j <= 2; ++j)
        for (int i = -2; i <= 2; ++i) {
            const Eigen::Vector2d pixel(static_cast<double>(cell % width) + i / 4.0,
                                        static_cast<double>(cell / width) + j / 4.0);
            const SurfaceHit hit = geometry.first_hit(
                eye, world_from_camera.rotation * ray_through(channel.camera, pixel));
            if (hit.object >= 0)
                least = std::min(
                    least, std::abs((point.position - eye).norm() - (hit.point - eye).norm()));
        }
    return least;
}

}  // namespace

Scene groove_scene(double degrees, double albedo, int width, int height) {
    Scene scene = scanner(width, height);
    // Half way between the directions of camera and laser; faces 150 mm from crease to rim.
    const double middle = 10 * kDegree, half = degrees / 2 * kDegree;
    const Eigen::Vector3d crease(0.4, 0, -450);
    SceneObject left =
        plate("left", {0, -80}, {150, 160}, about_y(-(M_PI / 2 - middle) - half), crease);
    SceneObject right =
        plate("right", {0, -80}, {150, 160}, about_y(-(M_PI / 2 - middle) + half), crease);
    left.albedo = right.albedo = albedo;
    scene.objects = {left, right};
    scene.reflection.bounce = true;
    return scene;
}

Scene mirror_scene(int width, int height) {
    Scene scene = scanner(width, height);
    SceneObject floor =
        plate("floor", {-90, -80}, {180, 160}, Eigen::Matrix3d::Identity(), {0, 0, -450});
    floor.albedo = 0.8;
    Eigen::Matrix3d upright;
    upright << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // its x along world y, its y along world z
    SceneObject mirror = plate("mirror", {-60, 0}, {120, 50}, upright, {-40, 0, -449.5});
    mirror.mirror = true;
    mirror.albedo = 0.9;
    scene.objects = {floor, mirror};
    scene.reflection.mirrors = true;
    return scene;
}

Scene plain_scene(int width, int height) {
    Scene scene = scanner(width, height);
    scene.objects[0].radius_mm = 25;
    scene.objects[0].world_from_object.translation = {-15, 5, -420};
    scene.objects[2].world_from_object.translation = {35, -10, -430};
    return scene;
}

GhostScan scan_ghosts(const Scene& scene, unsigned seed, const RangeOptions& options) {
    SimulatedScanner scanner(scene, seed);
    const ScannerModel model = scanner.truth_model();
    const Channel& channel = model.channels.front();
    const SimSweep sweep = record_sweep(scanner, scene.axis.min, scene.axis.max, 0.45e-3);
    const Frame& first = sweep.frames.front();
    const SensorNoise noise{scene.sensor.gain_e_per_dn, scene.sensor.read_noise_e,
                            scene.sensor.black_dn};
    SpacetimeAnalyser analyser(first.width, first.height, first.bits, noise, {.threads = 2});
    AxisLog log;
    for (std::size_t k = 0; k < sweep.frames.size(); ++k) {
        analyser.add(sweep.frames[k]);
        log.samples.push_back({sweep.frames[k].row_time(0), sweep.s[k]});
    }
    GhostScan scan;
    scan.pulses = analyser.finish();
    assign_axis_positions(scan.pulses, log);
    scan.range = range_from_pulses(scan.pulses, model, options);
    scan.statistics = scan.range.statistics;

    const RangeImage truth = scanner.true_range();
    const SceneGeometry geometry(scene);
    const Rigid3 world_from_camera = scan_from_camera(channel, 0);
    GhostCount& count = scan.count;
    scan.fates.assign(truth.cell_count(), GhostFate::dark);
    scan.errors_mm.assign(truth.cell_count(), std::nan(""));
    for (std::size_t i = 0; i < truth.cell_count(); ++i) {
        const bool lit = truth.mask[i] != 0;
        count.lit += lit;
        if (scan.pulses.cell_begin[i + 1] - scan.pulses.cell_begin[i] > 1) ++count.several;
        scan.fates[i] = lit ? GhostFate::missing : GhostFate::dark;
        if (!scan.range.image.mask[i]) continue;
        const RangePoint& point = scan.range.image.points[i];
        const double error = distance_in_pixel(geometry, channel, i, point);
        const double beam_mm =
            sigma_at(sheet_at(channel, point.s), world_from_camera.inverse() * point.position);
        const double allowed = std::max(5 * static_cast<double>(point.sigma_mm), beam_mm / 2);
        const bool wrong = error > allowed;
        scan.errors_mm[i] = error;
        if ((point.flags & kWarnings) != 0) {
            ++count.flagged;
            count.flagged_right += lit && !wrong;
            scan.fates[i] = GhostFate::flagged;
            continue;
        }
        ++count.points;
        count.wrong += wrong;
        count.right += lit && !wrong;
        scan.fates[i] = wrong ? GhostFate::wrong : GhostFate::right;
    }
    return scan;
}

ColourImage picture_of(const GhostScan& scan) {
    const RangeImage& image = scan.range.image;
    ColourImage picture(image.width, image.height, 3);
    for (std::size_t i = 0; i < scan.fates.size(); ++i) {
        std::uint8_t colour[3] = {0, 0, 0};
        switch (scan.fates[i]) {
            case GhostFate::dark:
                break;
            case GhostFate::missing:
                colour[0] = colour[1] = colour[2] = 110;
                break;
            case GhostFate::right:
                colour[0] = colour[1] = colour[2] = 255;
                break;
            case GhostFate::flagged:
                colour[0] = colour[1] = 230;
                break;
            case GhostFate::wrong:
                colour[0] = 255;
                break;
        }
        for (std::size_t c = 0; c < 3; ++c) picture.values[3 * i + c] = colour[c];
    }
    return picture;
}

}  // namespace stria::test

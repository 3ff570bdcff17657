#include "tests/host/scan/ghost_trials.h"

#include <Eigen/Geometry>
#include <cmath>
#include <optional>

#include "firmware/core/angle.h"
#include "firmware/stripe/spacetime.h"
#include "host/core/laser_sheet.h"
#include "sim/bounce_light.h"
#include "sim/mirror_light.h"
#include "sim/scene_geometry.h"
#include "sim/simulated_scanner.h"
#include "tests/sim/plate_scene.h"
#include "tests/sim/sim_sweep.h"

namespace stria::test {
namespace {

constexpr std::uint16_t kWarnings =
    kPulseOverlapping | kPulseGhostSuspected | kPulseWidthOutOfRange | kPulseTouchesSequenceEnd;

/// The same scanner with its laser on the other side of the camera.
void swap_sides(Channel& channel) {
    const Eigen::Vector3d across(-1, 1, 1);
    for (Eigen::Vector3d* v :
         {&channel.sheet.normal, &channel.sheet.apex, &channel.sheet.central_ray,
          &channel.axis.mirror.point, &channel.axis.mirror.normal0})
        *v = v->cwiseProduct(across);
    channel.axis.mirror.direction *= -1;  // a turn seen in a mirror
    channel.sheet.offset_mm = channel.sheet.normal.dot(channel.sheet.apex);
    channel.sheet = normalised(channel.sheet);
}

/// The built-in scanner with a picture 120 mm wide at 400 pixels.
Scene scanner(const GhostScanner& shape) {
    const int width = shape.width, height = shape.height;
    Scene scene = built_in_scene();
    if (shape.laser_on_left) swap_sides(scene.channel);
    CameraModel& camera = scene.channel.camera;
    camera.width = width;
    camera.height = height;
    camera.fx = camera.fy = 1450;
    camera.cx = (width - 1) / 2.0 + 0.3;
    camera.cy = (height - 1) / 2.0 - 0.2;
    scene.channel.sheet.waist_sigma_mm = shape.beam_sigma_mm;
    scene.sensor.full_well_e = 10500;
    scene.sensor.gain_e_per_dn = 40;
    scene.ambient_level = 0.02;
    scene.laser_power_mw = 25;
    return scene;
}

Eigen::Matrix3d about_y(double angle) {
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

/// What a pixel sees of light that came by way of another surface.
class ReflectedLight {
  public:
    ReflectedLight(const Scene& scene, const SceneGeometry& geometry)
        : scene_(scene),
          geometry_(geometry),
          beam_(scene),
          eye_(scan_from_camera(scene.channel, 0).translation) {
        if (scene.reflection.bounce) bounce_.emplace(scene, beam_, geometry);
        if (scene.reflection.mirrors) mirrors_.emplace(scene, beam_, geometry);
    }

    /// Whether its maximum lies within kClose standard deviations of the direct pulse and is as
    /// high as the least pulse that the analyser claims, min_snr times the noise of the dark.
    bool is_close(const Eigen::Vector2d& pixel) const {
        const Rigid3 pose = scan_from_camera(scene_.channel, 0);
        const SurfaceHit hit =
            geometry_.first_hit(eye_, pose.rotation * ray_through(scene_.channel.camera, pixel));
        if (hit.object < 0) return false;
        const auto direct = beam_.passing(hit, 0);
        if (!direct) return false;
        std::vector<StripeLight> lights;
        if (bounce_) bounce_->add(hit, eye_, 0, lights);
        if (mirrors_) mirrors_->add(hit, eye_, 1, 0, lights);
        double highest = 0, place = 0;
        constexpr double kStep = 0.1, kFarthest = 8;  // standard deviations
        for (double off = -kFarthest; off <= kFarthest; off += kStep) {
            double rate = 0;
            for (const StripeLight& light : lights) {
                const double z = (direct->position + off / direct->per_s - light.s0) * light.per_s;
                if (std::abs(z) < 6)
                    rate += static_cast<double>(light.rate) * std::exp(-0.5 * z * z);
            }
            if (rate > highest) {
                highest = rate;
                place = off;
            }
        }
        return std::abs(place) < kClose && highest > least_rate();
    }

    /// Whether the sheet reaches the surface all over a pixel: the centres of 5 x 5 parts.
    bool is_lit_all_over(const Eigen::Vector2d& pixel) const {
        const Rigid3 pose = scan_from_camera(scene_.channel, 0);
        for (int j = -2; j <= 2; ++j)
            for (int i = -2; i <= 2; ++i) {
                const Eigen::Vector2d part = pixel + Eigen::Vector2d(i, j) / 5;
                const SurfaceHit hit = geometry_.first_hit(
                    eye_, pose.rotation * ray_through(scene_.channel.camera, part));
                if (hit.object < 0) return false;
                const auto direct = beam_.passing(hit, 0);
                if (!direct || direct->rate <= 0 ||
                    geometry_.is_occluded(hit, direct->light_in_world))
                    return false;
            }
        return true;
    }

  private:
    static constexpr double kClose = 1.5;

    double least_rate() const {
        const SceneSensor& sensor = scene_.sensor;
        const double noise_dn = std::hypot(sensor.read_noise_e / sensor.gain_e_per_dn, 0.3);
        const SpacetimeOptions options;
        const double least_dn = std::max(options.min_snr * noise_dn, options.min_amplitude_dn);
        return least_dn * sensor.gain_e_per_dn / (sensor.exposure_us * 1e-6);
    }

    const Scene& scene_;
    const SceneGeometry& geometry_;
    Beam beam_;
    Eigen::Vector3d eye_;
    std::optional<BounceLight> bounce_;
    std::optional<MirrorLight> mirrors_;
};

}  // namespace

Scene groove_scene(const Groove& groove, const GhostScanner& shape) {
    Scene scene = scanner(shape);
    // Half way between the directions of camera and laser; faces 150 mm from crease to rim.
    const double side = shape.laser_on_left ? -1 : 1;
    const double middle = side * (10 + groove.turned_degrees) * kDegree;
    const double half = groove.degrees / 2 * kDegree;
    const Eigen::Vector3d crease(0.4, 0, -450);
    scene.objects = {
        rectangle("left", {0, -80}, {150, 160}, {about_y(-(M_PI / 2 - middle) - half), crease}),
        rectangle("right", {0, -80}, {150, 160}, {about_y(-(M_PI / 2 - middle) + half), crease})};
    for (SceneObject& face : scene.objects) face.albedo = groove.albedo;
    scene.reflection.bounce = true;
    return scene;
}

Scene mirror_scene(const UprightMirror& mirror, const GhostScanner& shape) {
    Scene scene = scanner(shape);
    const double side = shape.laser_on_left ? -1 : 1;
    SceneObject floor = rectangle("floor", {-90, -80}, {180, 160},
                                  {Eigen::Matrix3d::Identity(), Eigen::Vector3d(0, 0, -450)});
    floor.albedo = mirror.floor_albedo;
    Eigen::Matrix3d upright;
    upright << 0, 0, 1, 1, 0, 0, 0, 1, 0;  // its x along world y, its y along world z
    const Eigen::Matrix3d turn = about_y(-side * mirror.lean_degrees * kDegree) * upright;
    SceneObject glass =
        rectangle("mirror", {-60, 0}, {120, 50}, {turn, Eigen::Vector3d(-side * 40, 0, -449.5)});
    glass.mirror = true;
    glass.albedo = mirror.reflectance;
    scene.objects = {floor, glass};
    scene.reflection.mirrors = true;
    return scene;
}

Scene plain_scene(int width, int height) {
    Scene scene = scanner({.width = width, .height = height});
    scene.objects[0].radius_mm = 25;
    scene.objects[0].world_from_object.translation = {-15, 5, -420};
    scene.objects[2].world_from_object.translation = {35, -10, -430};
    return scene;
}

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
    const ReflectedLight reflected(scene, geometry);
    GhostCount& count = scan.count;
    scan.fates.assign(truth.cell_count(), GhostFate::dark);
    scan.errors_mm.assign(truth.cell_count(), std::nan(""));
    for (std::size_t i = 0; i < truth.cell_count(); ++i) {
        const bool lit = truth.mask[i] != 0;
        const auto columns = static_cast<std::size_t>(channel.camera.width);
        const Eigen::Vector2d pixel(static_cast<double>(i % columns),
                                    static_cast<double>(i / columns));
        const bool close = lit && reflected.is_close(pixel);
        count.lit += lit;
        count.close += close;
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
        count.wrong_partly_lit += wrong && !reflected.is_lit_all_over(pixel);
        count.right += lit && !wrong;
        count.close_right += close && !wrong;
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

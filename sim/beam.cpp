#include "sim/beam.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace stria {
namespace {

constexpr double kPlanckTimesLight = 1.98644586e-25;  ///< J m
constexpr double kSlowestPerS = 1e-6;                 ///< sigmas per unit of s; below it "at rest"

/// Electrons a second in a pixel that sees a white Lambert surface under 1 mW/mm^2:
/// E / pi * (pixel area) * pi / (4 N^2) * QE / (photon's energy).
double electrons_per_irradiance(const SceneSensor& sensor, double wavelength_nm) {
    const double watt_per_m2 = 1000.0;
    const double pixel_m = sensor.pixel_um * 1e-6;
    const double watt = watt_per_m2 * pixel_m * pixel_m / (4.0 * sensor.f_number * sensor.f_number);
    return watt * sensor.quantum_efficiency * wavelength_nm * 1e-9 / kPlanckTimesLight;
}

/// The sheet turned about its apex and across its fan, towards its normal's other side.
LaserSheet turned(LaserSheet sheet, double angle_rad) {
    const Eigen::Vector3d normal = sheet.normal, central = sheet.central_ray;
    sheet.normal = std::cos(angle_rad) * normal + std::sin(angle_rad) * central;
    sheet.central_ray = std::cos(angle_rad) * central - std::sin(angle_rad) * normal;
    sheet.offset_mm = sheet.normal.dot(sheet.apex);
    return sheet;
}

/// 1 within the fan, falling to 0 over the outer 2 % of its half angle.
double fan_share(const LaserSheet& sheet, double phi) {
    const double half = sheet.fan_rad / 2, soft = 0.02 * half;
    return std::clamp((half - std::abs(phi)) / soft, 0.0, 1.0);
}

}  // namespace

double oren_nayar(const Eigen::Vector3d& normal, const Eigen::Vector3d& to_light,
                  const Eigen::Vector3d& to_eye, double roughness_rad) {
    if (roughness_rad == 0) return 1;
    const double s2 = roughness_rad * roughness_rad;
    const double a = 1 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
    const double cos_light = std::clamp(normal.dot(to_light), 1e-6, 1.0);
    const double cos_eye = std::clamp(normal.dot(to_eye), 1e-6, 1.0);
    const Eigen::Vector3d light_side = to_light - cos_light * normal;
    const Eigen::Vector3d eye_side = to_eye - cos_eye * normal;
    const double scale = light_side.norm() * eye_side.norm();
    const double cos_between = scale > 1e-12 ? light_side.dot(eye_side) / scale : 0;
    // sin of the greater polar angle times tan of the lesser.
    const double sin_light = std::sqrt(1 - cos_light * cos_light);
    const double sin_eye = std::sqrt(1 - cos_eye * cos_eye);
    const double sin_tan = sin_light * sin_eye / std::max(cos_light, cos_eye);
    return a + b * std::max(0.0, cos_between) * sin_tan;
}

double glossy_lobe(const Eigen::Vector3d& normal, const Eigen::Vector3d& to_light,
                   const Eigen::Vector3d& to_eye, double alpha) {
    const double cos_light = normal.dot(to_light), cos_eye = normal.dot(to_eye);
    if (cos_light <= 0 || cos_eye <= 0) return 0;
    const double a2 = alpha * alpha;
    const double cos_half = normal.dot((to_light + to_eye).normalized());
    const double spread = cos_half * cos_half * (a2 - 1) + 1;
    const double d = a2 / (std::numbers::pi * spread * spread);
    // G / (4 cos cos) with Smith's G1 = 2 cos / (cos + sqrt(a2 + (1 - a2) cos^2)).
    const auto half_g = [&](double c) { return c + std::sqrt(a2 + (1 - a2) * c * c); };
    return d / (half_g(cos_light) * half_g(cos_eye));
}

double reflected_share(const SurfaceHit& hit, const Eigen::Vector3d& to_light,
                       const Eigen::Vector3d& to_eye) {
    const Eigen::Vector3d normal = hit.normal.cast<double>();
    double share = static_cast<double>(hit.albedo) *
                   oren_nayar(normal, to_light, to_eye, static_cast<double>(hit.roughness_rad));
    if (hit.specular > 0)
        share += std::numbers::pi * static_cast<double>(hit.specular) *
                 glossy_lobe(normal, to_light, to_eye, static_cast<double>(hit.gloss));
    return share;
}

HeadPose head_pose(const Channel& channel, double s) {
    const Rigid3 world_from_camera = scan_from_camera(channel, s);
    return {world_from_camera, world_from_camera.inverse()};
}

double fresnel_transmission(double cos_incidence, double refractive_index) {
    const double ci = std::clamp(cos_incidence, 0.0, 1.0), n = refractive_index;
    const double ct = std::sqrt(1 - (1 - ci * ci) / (n * n));
    const double across = (ci - n * ct) / (ci + n * ct), along = (n * ci - ct) / (n * ci + ct);
    return 1 - (across * across + along * along) / 2;
}

Beam::Beam(const Scene& scene, int order)
    : channel_(scene.channel),
      profile_(scene.line, scene.channel.sheet.fan_rad),
      parts_(scene),
      m2_(scene.line.m2) {
    if (order != 0) channel_.sheet = turned(channel_.sheet, order * scene.line.ghost_rad);
    if (parts_.has_inside())
        for (const SceneObject& object : scene.objects)
            materials_.push_back({object.mirror ? 0 : object.subsurface, object.free_path_mm,
                                  object.refractive_index});
    const MirrorAxis& mirror = channel_.axis.mirror;
    mirror_along_ = mirror.direction.dot(mirror.normal0) * mirror.direction;
    mirror_cosine_ = mirror.normal0 - mirror_along_;
    mirror_sine_ = mirror.direction.cross(mirror.normal0);
    middle_s_ = (scene.axis.min + scene.axis.max) / 2;
    half_travel_ = (scene.axis.max - scene.axis.min) / 2;
    electrons_per_irradiance_ =
        electrons_per_irradiance(scene.sensor, channel_.sheet.wavelength_nm);
    laser_power_mw_ =
        scene.laser_power_mw * (order == 0 ? 1 - 2 * scene.line.ghost : scene.line.ghost);
    ambient_rate_ =
        scene.ambient_level * full_scale_e(scene.sensor) / (scene.sensor.exposure_us * 1e-6);
}

double Beam::rate(const SurfaceHit& hit, const Rigid3& world_from_camera,
                  const Eigen::Vector3d& eye_in_world, const Eigen::Vector3d& unfolded_in_camera,
                  const Eigen::Vector3d& apex_in_camera, double sigma_mm) const {
    const LaserSheet& sheet = channel_.sheet;
    const Eigen::Vector3d apex = world_from_camera * apex_in_camera;
    const Eigen::Vector3d normal = hit.normal.cast<double>();
    const double range_mm = (apex - hit.point).norm();
    const Eigen::Vector3d to_light = (apex - hit.point) / range_mm;
    const double cos_incidence = normal.dot(to_light);
    if (cos_incidence <= 0 || hit.albedo + hit.specular <= 0) return 0;
    if (sheet.central_ray.dot(unfolded_in_camera - sheet.apex) <= 0) return 0;
    const double phi = fan_angle(sheet, unfolded_in_camera);
    const double share = fan_share(sheet, phi) * profile_.at(phi);
    if (share <= 0) return 0;
    const Eigen::Vector3d to_eye = (eye_in_world - hit.point).normalized();
    const double irradiance =
        laser_power_mw_ * share * cos_incidence /
        (sheet.fan_rad * range_mm * std::sqrt(2 * std::numbers::pi) * sigma_mm);
    return electrons_per_irradiance_ * irradiance * reflected_share(hit, to_light, to_eye);
}

double Beam::width_at(const Eigen::Vector3d& point) const {
    if (m2_ == 1) return sigma_at(channel_.sheet, point);
    LaserSheet sheet = channel_.sheet;
    sheet.wavelength_nm *= m2_;  // z_R = 4 pi sigma0^2 / (M^2 lambda)
    return sigma_at(sheet, point);
}

LightShape Beam::shape_of(const SurfaceHit& hit, const BeamAtPoint& beam,
                          const Eigen::Vector3d& eye_in_world, const Eigen::Vector3d& across,
                          double sigma_mm, bool grows) const {
    LightShape shape;
    shape.way = grows ? 1.0F : -1.0F;
    if (materials_.empty() || hit.albedo <= 0) return shape;
    const Material& material = materials_[static_cast<std::size_t>(hit.object)];
    if (material.subsurface == 0) return shape;
    const Eigen::Vector3d normal = hit.normal.cast<double>();
    const Eigen::Vector3d ray = (hit.point - beam.light_in_world).normalized();
    const double cos_incidence = -normal.dot(ray);
    // Along the surface: the incoming ray's part over n, by Snell's law the refracted one's.
    const Eigen::Vector3d displacement =
        material.free_path_mm / material.refractive_index * (ray + cos_incidence * normal);
    const Eigen::Vector3d in_surface = across - normal.dot(across) * normal;
    double share =
        material.subsurface * fresnel_transmission(cos_incidence, material.refractive_index);
    if (hit.specular > 0) {  // what is mirrored does not enter
        const Eigen::Vector3d to_eye = (eye_in_world - hit.point).normalized();
        SurfaceHit matt = hit;
        matt.specular = 0;
        share *= reflected_share(matt, -ray, to_eye) / reflected_share(hit, -ray, to_eye);
    }
    shape.inside = static_cast<float>(share);
    shape.shift = static_cast<float>(in_surface.dot(displacement) / sigma_mm);
    shape.spread = static_cast<float>(material.free_path_mm * in_surface.norm() / sigma_mm);
    return shape;
}

std::optional<BeamAtPoint> Beam::passing(const SurfaceHit& hit, double guess) const {
    return passing(hit, guess, scan_from_camera(channel_, 0).translation);
}

std::optional<BeamAtPoint> Beam::passing(const SurfaceHit& hit, double guess,
                                         const Eigen::Vector3d& eye_in_world) const {
    const MirrorAxis& mirror = channel_.axis.mirror;
    const LaserSheet& sheet = channel_.sheet;
    const Rigid3 world_from_camera = scan_from_camera(channel_, 0);
    const Eigen::Vector3d p =
        world_from_camera.rotation.transpose() * (hit.point - world_from_camera.translation);
    const Eigen::Vector3d from_axis = p - mirror.point;

    // The sheet reflected at s holds p where the incoming sheet holds the mirror image of p.
    double s = guess, slope = 0;
    Eigen::Vector3d m, image;
    for (int i = 0; i < 12; ++i) {
        const double g = s + s * s * (mirror.g2 + s * mirror.g3);
        const double cos_g = std::cos(g), sin_g = std::sin(g);
        m = mirror_along_ + cos_g * mirror_cosine_ + sin_g * mirror_sine_;
        const Eigen::Vector3d dm = cos_g * mirror_sine_ - sin_g * mirror_cosine_;
        const double height = m.dot(from_axis) - mirror.offset_mm;
        image = p - 2 * height * m;
        const double distance = signed_distance(sheet, image);
        const double dg_ds = 1 + s * (2 * mirror.g2 + 3 * s * mirror.g3);
        slope =
            -2 * dg_ds * (dm.dot(from_axis) * sheet.normal.dot(m) + height * sheet.normal.dot(dm));
        if (std::abs(slope) < 1e-9) return std::nullopt;
        const double step = std::clamp(distance / slope, -0.2, 0.2);
        s -= step;
        if (std::abs(step) < 1e-9) break;  // the next would be below 1e-12: the bow bends little
    }
    if (!(std::abs(s - middle_s_) <= 2 * half_travel_)) return std::nullopt;

    const double height_of_apex = m.dot(sheet.apex - mirror.point) - mirror.offset_mm;
    const Eigen::Vector3d apex = sheet.apex - 2 * height_of_apex * m;  // seen in the mirror
    const double sigma_mm = width_at(image);
    BeamAtPoint beam;
    beam.position = s;
    beam.per_position = beam.per_s = std::abs(slope) / sigma_mm;
    beam.rate = rate(hit, world_from_camera, eye_in_world, image, apex, sigma_mm);
    // Shadows end at the mirror, not at the apex behind it.
    const double height = m.dot(from_axis) - mirror.offset_mm;
    const double at_mirror = height / (height + height_of_apex);
    if (!(at_mirror > 0 && at_mirror <= 1))
        beam.rate = 0;  // the point is behind the mirror
    else
        beam.light_in_world = world_from_camera * Eigen::Vector3d(p + at_mirror * (apex - p));
    if (parts_.is_shaped() && beam.rate > 0) {
        const Eigen::Vector3d across = sheet.normal - 2 * m.dot(sheet.normal) * m;
        beam.shape = shape_of(hit, beam, eye_in_world, world_from_camera.rotation * across,
                              sigma_mm, slope > 0);
    }
    return beam;
}

BeamAtPoint Beam::beside(const SurfaceHit& hit, const HeadPose& head, double travel,
                         double pixels) const {
    const LaserSheet& sheet = channel_.sheet;
    const Eigen::Vector3d p = head.camera_from_world * hit.point;
    const double sigma_mm = width_at(p);
    BeamAtPoint beam;
    beam.position = signed_distance(sheet, p);
    beam.per_position = 1 / sigma_mm;

    // The part's velocity (camera frame, per unit of s), and how it moves the hit along the ray.
    const Eigen::Vector3d velocity =
        channel_.axis.kind == MachineKind::rail
            ? Eigen::Vector3d(-channel_.axis.rail.direction)
            : Eigen::Vector3d(head.camera_from_world.rotation *
                              Eigen::Vector3d::UnitZ().cross(hit.point));
    const Eigen::Vector3d normal = head.camera_from_world.rotation * hit.normal.cast<double>();
    const double across = normal.dot(p);
    double speed = 0;  // along the ray, as a multiple of p
    if (std::abs(across) > 1e-9 * p.norm()) speed = normal.dot(velocity) / across;
    // The distance changes by at most |speed| |p| per unit of s.
    const double reach_mm = 6 * sigma_mm + pixels * p.norm() / channel_.camera.fx +
                            std::abs(speed) * p.norm() * travel / 2;
    beam.is_near = std::abs(beam.position) < reach_mm || travel == 0;
    if (!beam.is_near) return beam;

    const double h = 1e-4 / std::max(1e-12, std::abs(speed));
    if (speed != 0)
        beam.per_s = (signed_distance(sheet, p * (1 + h * speed)) - beam.position) / (h * sigma_mm);
    if (std::abs(beam.per_s) < kSlowestPerS) beam.per_s = kSlowestPerS;
    beam.rate = rate(hit, head.world_from_camera, head.world_from_camera.translation, p, sheet.apex,
                     sigma_mm);
    beam.light_in_world = head.world_from_camera * sheet.apex;
    if (parts_.is_shaped() && beam.rate > 0)
        beam.shape =
            shape_of(hit, beam, head.world_from_camera.translation,
                     head.world_from_camera.rotation * sheet.normal, sigma_mm, beam.per_s > 0);
    return beam;
}

BeamRay Beam::ray(double s, double phi) const {
    const MirrorAxis& mirror = channel_.axis.mirror;
    const double g = s + s * s * (mirror.g2 + s * mirror.g3);
    const Eigen::Vector3d m =
        mirror_along_ + std::cos(g) * mirror_cosine_ + std::sin(g) * mirror_sine_;
    const LaserSheet sheet = sheet_at(channel_, s);
    const double bow = phi * phi * (sheet.bow2 + phi * sheet.bow3);
    const Eigen::Vector3d direction = std::cos(phi) * sheet.central_ray +
                                      std::sin(phi) * sheet.normal.cross(sheet.central_ray) +
                                      std::tan(bow) * sheet.normal;
    // The image of the apex lies behind the mirror; light starts where its ray leaves the mirror.
    const double to_mirror =
        (mirror.offset_mm - m.dot(sheet.apex - mirror.point)) / m.dot(direction);
    const Rigid3 world_from_camera = scan_from_camera(channel_, s);
    BeamRay ray;
    ray.origin = world_from_camera * Eigen::Vector3d(sheet.apex + to_mirror * direction);
    ray.direction = (world_from_camera.rotation * direction).normalized();
    const double share = fan_share(sheet, phi) * profile_.at(phi);
    ray.mw_per_rad = to_mirror > 0 ? laser_power_mw_ * share / sheet.fan_rad : 0;
    return ray;
}

}  // namespace stria

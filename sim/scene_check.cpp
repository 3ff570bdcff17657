#include <algorithm>
#include <cmath>
#include <set>

#include "sim/scene.h"
#include "sim/screen_speckle.h"

namespace stria {
namespace {

constexpr std::int64_t kMostPixels = std::int64_t{1} << 25;  ///< about 3 GB of rays and light
constexpr double kLongestMoveS = 3600;                       ///< bounds the axis log

std::string wrong(const std::string& field, double value, const std::string& bound) {
    return field + " = " + std::to_string(value) + ": expected " + bound;
}

bool is_unit(const Eigen::Vector3d& v) { return std::abs(v.norm() - 1.0) < 1e-6; }

std::string validate_sensor(const SceneSensor& sensor) {
    if (!(sensor.full_well_e > 0))
        return wrong("sensor.full_well_e", sensor.full_well_e, "above 0");
    if (!(sensor.read_noise_e >= 0))
        return wrong("sensor.read_noise_e", sensor.read_noise_e, "0 or more");
    if (!(sensor.gain_e_per_dn > 0))
        return wrong("sensor.gain_e_per_dn", sensor.gain_e_per_dn, "above 0");
    if (sensor.bits < 8 || sensor.bits > 16) return wrong("sensor.bits", sensor.bits, "8 to 16");
    if (!(sensor.exposure_us >= 1 && sensor.exposure_us <= 1e7))
        return wrong("sensor.exposure_us", sensor.exposure_us, "1 to 1e7");
    if (!(sensor.row_time_us >= 0 && sensor.row_time_us <= 1e4))
        return wrong("sensor.row_time_us", sensor.row_time_us, "0 to 1e4");
    if (!(sensor.black_dn >= 0 && sensor.black_dn < (1 << sensor.bits)))
        return wrong("sensor.black_dn", sensor.black_dn, "0 to full scale");
    if (!(sensor.min_frame_period_us >= 1 && sensor.min_frame_period_us <= 1e7))
        return wrong("sensor.min_frame_period_us", sensor.min_frame_period_us, "1 to 1e7");
    if (!(sensor.pixel_um > 0)) return wrong("sensor.pixel_um", sensor.pixel_um, "above 0");
    if (!(sensor.f_number > 0)) return wrong("sensor.f_number", sensor.f_number, "above 0");
    if (!(sensor.quantum_efficiency > 0 && sensor.quantum_efficiency <= 1))
        return wrong("sensor.quantum_efficiency", sensor.quantum_efficiency, "above 0, at most 1");
    if (!(sensor.prnu >= 0 && sensor.prnu <= 0.1))
        return wrong("sensor.prnu", sensor.prnu, "0 to 0.1");
    if (!(sensor.dsnu_e >= 0 && sensor.dsnu_e <= 1000))
        return wrong("sensor.dsnu_e", sensor.dsnu_e, "0 to 1000");
    if (!(sensor.dark_current_e_per_s >= 0 && sensor.dark_current_e_per_s <= 1e5))
        return wrong("sensor.dark_current_e_per_s", sensor.dark_current_e_per_s, "0 to 1e5");
    if (!(sensor.blooming >= 0 && sensor.blooming <= 1))
        return wrong("sensor.blooming", sensor.blooming, "0 to 1");
    if (!(sensor.gamma >= 0.3 && sensor.gamma <= 3))
        return wrong("sensor.gamma", sensor.gamma, "0.3 to 3");
    return "";
}

std::string validate_lens_and_flicker(const Scene& scene) {
    const SceneLens& lens = scene.lens;
    if (!(lens.psf_sigma_px >= 0 && lens.psf_sigma_px <= 8))
        return wrong("lens.psf_sigma_px", lens.psf_sigma_px, "0 to 8");
    const double focal_mm = scene.channel.camera.fx * scene.sensor.pixel_um * 1e-3;
    if (!(lens.focus_mm == 0 || (lens.focus_mm > 2 * focal_mm && lens.focus_mm <= 1e6)))
        return wrong(
            "lens.focus_mm", lens.focus_mm,
            "0 or more than twice the focal length, " + std::to_string(2 * focal_mm) + ", to 1e6");
    if (!(lens.corner_loss >= 0 && lens.corner_loss <= 0.95))
        return wrong("lens.corner_loss", lens.corner_loss, "0 to 0.95");
    if (!(scene.flicker.hz >= 1 && scene.flicker.hz <= 10000))
        return wrong("ambient.flicker_hz", scene.flicker.hz, "1 to 10000");
    if (!(scene.flicker.depth >= 0 && scene.flicker.depth <= 1))
        return wrong("ambient.flicker_depth", scene.flicker.depth, "0 to 1");
    return "";
}

std::string validate_line(const SceneLine& line) {
    if (!(line.ripple >= 0 && line.ripple <= 0.9))
        return wrong("laser.ripple", line.ripple, "0 to 0.9");
    if (!(line.ripple_rad >= 0.001 && line.ripple_rad <= 3))
        return wrong("laser.ripple_rad", line.ripple_rad, "0.001 to 3");
    if (!(line.falloff_rad == 0 || (line.falloff_rad >= 0.05 && line.falloff_rad <= 3)))
        return wrong("laser.falloff_rad", line.falloff_rad, "0 or 0.05 to 3");
    if (!(line.m2 >= 1 && line.m2 <= 20)) return wrong("laser.m2", line.m2, "1 to 20");
    if (!(line.lobe >= 0 && line.lobe <= 0.2)) return wrong("laser.lobe", line.lobe, "0 to 0.2");
    if (!(std::abs(line.lobe_shift) <= 4))
        return wrong("laser.lobe_shift", line.lobe_shift, "-4 to 4");
    if (!(line.ghost >= 0 && line.ghost <= 0.2))
        return wrong("laser.ghost", line.ghost, "0 to 0.2");
    if (!(line.ghost_rad >= 0.001 && line.ghost_rad <= 0.5))
        return wrong("laser.ghost_rad", line.ghost_rad, "0.001 to 0.5");
    return "";
}

std::string validate_speckle(const Scene& scene) {
    const SceneSpeckle& speckle = scene.speckle;
    if (speckle.model == SpeckleModel::none) return "";
    if (speckle.model == SpeckleModel::screen) {
        if (scene.channel.axis.kind != MachineKind::swept)
            return "laser.speckle.model: screen keeps its pattern in the image, so it is for swept "
                   "machines: expected surface";
        if (!(speckle.contrast >= 0.7071 && speckle.contrast <= 1))
            return wrong("laser.speckle.contrast", speckle.contrast, "0.7072 to 1 (screen)");
        const double rho_px = speckle_px(scene);
        if (!(rho_px >= 1.0 / 64 && rho_px <= 32))
            return wrong("laser.speckle: lambda f_number / pixel_um", rho_px, "1 / 64 to 32 px");
        return "";
    }
    if (!(speckle.contrast >= 0.02 && speckle.contrast <= 1))
        return wrong("laser.speckle.contrast", speckle.contrast, "0.02 to 1");
    if (!(speckle.length_mm >= 0.005 && speckle.length_mm <= 10))
        return wrong("laser.speckle.length_mm", speckle.length_mm, "0.005 to 10");
    return "";
}

std::string validate_laser_and_axis(const Scene& scene) {
    const LaserSheet& sheet = scene.channel.sheet;
    if (!is_unit(sheet.normal)) return wrong("laser.normal's length", sheet.normal.norm(), "1");
    if (!is_unit(sheet.central_ray))
        return wrong("laser.central_ray's length", sheet.central_ray.norm(), "1");
    if (!(sheet.waist_sigma_mm > 0))
        return wrong("laser.waist_sigma_mm", sheet.waist_sigma_mm, "above 0");
    if (!(sheet.fan_rad > 0 && sheet.fan_rad < 3.1))
        return wrong("laser.fan_rad", sheet.fan_rad, "above 0, below 3.1");
    if (!(sheet.wavelength_nm >= 200 && sheet.wavelength_nm <= 2000))
        return wrong("laser.wavelength_nm", sheet.wavelength_nm, "200 to 2000");
    if (!(scene.laser_power_mw >= 0))
        return wrong("laser.power_mw", scene.laser_power_mw, "0 or more");
    if (std::string why = validate_speckle(scene); !why.empty()) return why;
    if (std::string why = validate_line(scene.line); !why.empty()) return why;
    const SceneAxis& axis = scene.axis;
    if (!(axis.min < axis.max)) return wrong("axis.min", axis.min, "below axis.max");
    if (!(std::isfinite(axis.min) && std::isfinite(axis.max)))
        return "axis.min and axis.max: expected finite numbers";
    if (!(axis.max_speed > 0)) return wrong("axis.max_speed", axis.max_speed, "above 0");
    if (!(axis.sigma >= 0)) return wrong("axis.sigma", axis.sigma, "0 or more");
    if (!((axis.max - axis.min) / axis.max_speed <= kLongestMoveS))
        return wrong("axis.max_speed", axis.max_speed, "the whole travel within an hour");
    if (!(axis.log_period_us >= 50 && axis.log_period_us <= 1e6))
        return wrong("axis.log_period_us", axis.log_period_us, "50 to 1e6");
    if (!(axis.periodic_error >= 0 && std::isfinite(axis.periodic_error)))
        return wrong("axis.periodic_error", axis.periodic_error, "0 or more");
    if (!(axis.periodic_length > 0 && axis.periodic_length >= 4 * M_PI * axis.periodic_error))
        return wrong("axis.periodic_length", axis.periodic_length,
                     "above 0 and at least 4 pi periodic_error");
    if (!(axis.wobble >= 0 && axis.wobble <= (axis.max - axis.min) / 10))
        return wrong("axis.wobble", axis.wobble, "0 to a tenth of the travel");
    if (!(axis.lag_us >= 0 && axis.lag_us <= 1e5))
        return wrong("axis.lag_us", axis.lag_us, "0 to 1e5");
    if (!(std::abs(scene.channel.axis.delay_ns) < 1e8))
        return wrong("axis.delay_ns", scene.channel.axis.delay_ns, "-1e8 to 1e8");
    return "";
}

std::string validate_reflection(const Scene& scene) {
    const SceneReflection& reflection = scene.reflection;
    if ((reflection.bounce || reflection.mirrors) && scene.channel.axis.kind != MachineKind::swept)
        return "reflection: bounce and mirrors are simulated for swept machines only, found " +
               std::string(name_of(scene.channel.axis.kind));
    for (const SceneObject& object : scene.objects)
        if (reflection.mirrors && object.mirror && object.shape != SceneShape::plane)
            return "object '" + object.name +
                   "': with reflection.mirrors a mirror is a plane, found another shape";
    return "";
}

std::string validate_object(const SceneObject& object) {
    const std::string where = "object '" + object.name + "': ";
    if (!is_rigid(object.world_from_object))
        return where + "world_from_object is not a rigid motion";
    if (!(object.albedo >= 0 && object.albedo <= 1))
        return where + wrong("albedo", object.albedo, "0 to 1");
    if (!(object.roughness_rad >= 0 && object.roughness_rad <= 1.5))
        return where + wrong("roughness", object.roughness_rad, "0 to 1.5");
    if (!(object.specular >= 0 && object.specular + (object.mirror ? 0 : object.albedo) <= 1))
        return where + wrong("specular", object.specular, "0 or more, with albedo at most 1");
    if (!(object.gloss >= 0.05 && object.gloss <= 1))
        return where + wrong("gloss", object.gloss, "0.05 to 1");
    if (!(object.subsurface >= 0 && object.subsurface <= 1))
        return where + wrong("subsurface", object.subsurface, "0 to 1");
    if (!(object.free_path_mm >= 0.01 && object.free_path_mm <= 10))
        return where + wrong("free_path_mm", object.free_path_mm, "0.01 to 10");
    if (!(object.refractive_index >= 1 && object.refractive_index <= 3))
        return where + wrong("refractive_index", object.refractive_index, "1 to 3");
    switch (object.shape) {
        case SceneShape::sphere:
            if (!(object.radius_mm > 0))
                return where + wrong("radius", object.radius_mm, "above 0");
            break;
        case SceneShape::plane:
            if (!(object.size_mm.minCoeff() > 0))
                return where + wrong("size", object.size_mm.minCoeff(), "above 0");
            break;
        case SceneShape::mesh:
            if (!object.mesh) return where + "has no mesh: expected file";
            if (object.mesh->triangles.empty()) return where + "its mesh has no triangles";
            for (const auto& triangle : object.mesh->triangles)
                for (std::uint32_t vertex : triangle)
                    if (vertex >= object.mesh->positions.size())
                        return where + "its mesh has a triangle with vertex " +
                               std::to_string(vertex) + ": expected below " +
                               std::to_string(object.mesh->positions.size());
            break;
    }
    if (object.texture_image &&
        (object.texture_image->empty() || object.texture_image->channels != 1))
        return where + "texture: expected a grey image";
    if (object.texture_image && !(object.texture_size_mm.minCoeff() > 0))
        return where + wrong("texture_size_mm", object.texture_size_mm.minCoeff(), "above 0");
    return "";
}

std::string validate_views(const Scene& scene) {
    std::set<std::string> names;
    for (const SceneObject& object : scene.objects)
        if (!names.insert(object.name).second)
            return "object '" + object.name + "' is there twice: expected names of their own";
    for (const SceneView& view : scene.views) {
        const std::string where = "view '" + view.name + "': ";
        for (const ViewPose& pose : view.poses) {
            if (!names.count(pose.object)) return where + "no object '" + pose.object + "'";
            if (!is_rigid(pose.world_from_object))
                return where + "pose of '" + pose.object + "' is not a rigid motion";
        }
        for (const std::string& hidden : view.hidden)
            if (!names.count(hidden)) return where + "no object '" + hidden + "' to hide";
    }
    return "";
}

}  // namespace

std::string validate(const Scene& scene) {
    ScannerModel model;
    model.channels.push_back(scene.channel);
    if (std::string why = validate(model); !why.empty()) return why;
    const CameraModel& camera = scene.channel.camera;
    if (std::int64_t{camera.width} * camera.height > kMostPixels)
        return "camera: " + std::to_string(camera.width) + " x " + std::to_string(camera.height) +
               " pixels: expected at most " + std::to_string(kMostPixels) + " in all";
    if (std::string why = validate_sensor(scene.sensor); !why.empty()) return why;
    if (std::string why = validate_lens_and_flicker(scene); !why.empty()) return why;
    if (std::string why = validate_laser_and_axis(scene); !why.empty()) return why;
    for (const SceneObject& object : scene.objects)
        if (std::string why = validate_object(object); !why.empty()) return why;
    if (std::string why = validate_reflection(scene); !why.empty()) return why;
    if (std::string why = validate_views(scene); !why.empty()) return why;
    if (!(scene.ambient_level >= 0 && scene.ambient_level <= 10))
        return wrong("ambient.level", scene.ambient_level, "0 to 10");
    const SceneNominal& nominal = scene.nominal;
    if (!(nominal.rotation_sigma_rad >= 0 && nominal.position_sigma_mm >= 0 &&
          nominal.focal_relative_sigma >= 0 && nominal.focal_relative_sigma < 0.2))
        return "nominal: expected sigmas of 0 or more, focal_relative_sigma below 0.2";
    const SceneFault& fault = scene.fault;
    if (!(fault.drop_frame_probability >= 0 && fault.drop_frame_probability < 1))
        return wrong("fault.drop_frame_probability", fault.drop_frame_probability, "0 to below 1");
    if (!(fault.duplicate_frame_probability >= 0 && fault.duplicate_frame_probability <= 1))
        return wrong("fault.duplicate_frame_probability", fault.duplicate_frame_probability,
                     "0 to 1");
    if (!(fault.timing_jitter_us >= 0))
        return wrong("fault.timing_jitter_us", fault.timing_jitter_us, "0 or more");
    return "";
}

}  // namespace stria

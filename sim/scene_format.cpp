#include <charconv>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "host/io/mesh_io.h"
#include "sim/scene.h"

namespace stria {
namespace {

std::string word(double value) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, value + 0.0).ptr;  // no "-0"
    return {buffer, end};
}

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        out += c;
    }
    return out + '"';
}

template <typename Vector>
std::string list(const Vector& values) {
    std::string out = "[";
    for (Eigen::Index i = 0; i < values.size(); ++i) out += (i ? ", " : "") + word(values[i]);
    return out + "]";
}

std::string list(const Rigid3& motion) {
    std::string out = "[";
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) out += word(motion.rotation(row, column)) + ", ";
        out += word(motion.translation[row]) + ", ";
    }
    return out + "0, 0, 0, 1]";
}

/// "key = value" lines of one table.
class TableText {
  public:
    explicit TableText(std::string& text, const std::string& head) : text_(text) {
        text_ += "\n" + head + "\n";
    }
    TableText& line(const std::string& key, const std::string& value) {
        text_ += key + " = " + value + "\n";
        return *this;
    }
    TableText& number(const std::string& key, double value) { return line(key, word(value)); }

  private:
    std::string& text_;
};

void format_camera_and_sensor(const Scene& scene, std::string& text) {
    const CameraModel& camera = scene.channel.camera;
    const Eigen::Map<const Eigen::VectorXd> distortion(camera.distortion.data(),
                                                       distortion_count(camera.kind));
    TableText(text, "[camera]")
        .line("model", quoted(name_of(camera.kind)))
        .number("width", camera.width)
        .number("height", camera.height)
        .number("fx", camera.fx)
        .number("fy", camera.fy)
        .number("cx", camera.cx)
        .number("cy", camera.cy)
        .line("distortion", list(distortion));
    const SceneSensor& sensor = scene.sensor;
    TableText(text, "[sensor]")
        .number("full_well_e", sensor.full_well_e)
        .number("read_noise_e", sensor.read_noise_e)
        .number("gain_e_per_dn", sensor.gain_e_per_dn)
        .number("bits", sensor.bits)
        .number("exposure_us", sensor.exposure_us)
        .number("row_time_us", sensor.row_time_us)
        .number("black_dn", sensor.black_dn)
        .number("min_frame_period_us", sensor.min_frame_period_us)
        .number("pixel_um", sensor.pixel_um)
        .number("f_number", sensor.f_number)
        .number("quantum_efficiency", sensor.quantum_efficiency)
        .line("noise", sensor.noise ? "true" : "false")
        .number("prnu", sensor.prnu)
        .number("dsnu_e", sensor.dsnu_e)
        .number("dark_current_e_per_s", sensor.dark_current_e_per_s)
        .line("cut_edges", sensor.cut_edges ? "true" : "false")
        .number("blooming", sensor.blooming)
        .number("gamma", sensor.gamma);
    TableText(text, "[lens]")
        .number("psf_sigma_px", scene.lens.psf_sigma_px)
        .number("focus_mm", scene.lens.focus_mm)
        .line("cos4", scene.lens.cos4 ? "true" : "false")
        .number("corner_loss", scene.lens.corner_loss);
    TableText(text, "[reflection]")
        .line("bounce", scene.reflection.bounce ? "true" : "false")
        .line("mirrors", scene.reflection.mirrors ? "true" : "false");
}

void format_laser_and_axis(const Scene& scene, std::string& text) {
    const LaserSheet& sheet = scene.channel.sheet;
    TableText(text, "[laser]")
        .number("wavelength_nm", sheet.wavelength_nm)
        .number("power_mw", scene.laser_power_mw)
        .line("apex", list(sheet.apex))
        .line("central_ray", list(sheet.central_ray))
        .line("normal", list(sheet.normal))
        .number("waist_sigma_mm", sheet.waist_sigma_mm)
        .number("waist_at_mm", sheet.waist_at_mm)
        .number("fan_rad", sheet.fan_rad)
        .number("bow2", sheet.bow2)
        .number("bow3", sheet.bow3)
        .number("ripple", scene.line.ripple)
        .number("ripple_rad", scene.line.ripple_rad)
        .number("falloff_rad", scene.line.falloff_rad)
        .number("m2", scene.line.m2)
        .number("lobe", scene.line.lobe)
        .number("lobe_shift", scene.line.lobe_shift)
        .number("ghost", scene.line.ghost)
        .number("ghost_rad", scene.line.ghost_rad);
    TableText(text, "[laser.speckle]")
        .line("model", quoted(name_of(scene.speckle.model)))
        .number("contrast", scene.speckle.contrast)
        .number("length_mm", scene.speckle.length_mm);
    const AxisModel& model = scene.channel.axis;
    TableText axis(text, "[axis]");
    if (model.kind == MachineKind::swept)
        axis.line("direction", list(model.mirror.direction))
            .line("point", list(model.mirror.point))
            .line("normal0", list(model.mirror.normal0))
            .number("offset_mm", model.mirror.offset_mm)
            .number("g2", model.mirror.g2)
            .number("g3", model.mirror.g3);
    if (model.kind == MachineKind::rail) axis.line("direction", list(model.rail.direction));
    if (model.kind == MachineKind::turntable)
        axis.line("table_from_camera", list(model.turntable.table_from_camera));
    axis.number("delay_ns", model.delay_ns)
        .number("min", scene.axis.min)
        .number("max", scene.axis.max)
        .number("max_speed", scene.axis.max_speed)
        .number("sigma", scene.axis.sigma)
        .number("log_period_us", scene.axis.log_period_us)
        .number("periodic_error", scene.axis.periodic_error)
        .number("periodic_length", scene.axis.periodic_length)
        .number("wobble", scene.axis.wobble)
        .number("lag_us", scene.axis.lag_us);
}

void format_object(const SceneObject& object, std::string& text) {
    TableText table(text, "[[object]]");
    table.line("name", quoted(object.name));
    switch (object.shape) {
        case SceneShape::sphere:
            table.line("shape", quoted("sphere")).number("radius", object.radius_mm);
            break;
        case SceneShape::plane:
            table.line("shape", quoted("plane"))
                .line("size", list(object.size_mm))
                .line("corner", list(object.corner_mm));
            break;
        case SceneShape::mesh:
            if (object.file.empty())
                throw std::invalid_argument("format_scene: object '" + object.name +
                                            "' has a mesh from memory: expected a file");
            table.line("shape", quoted("mesh")).line("file", quoted(object.file));
            for (const char* unit : {"m", "um", "in"})
                if (mm_per_unit(unit) == object.mm_per_unit) table.line("unit", quoted(unit));
            break;
    }
    table.line("world_from_object", list(object.world_from_object))
        .number("albedo", object.albedo)
        .number("roughness", object.roughness_rad)
        .number("specular", object.specular)
        .number("gloss", object.gloss)
        .number("subsurface", object.subsurface)
        .number("free_path_mm", object.free_path_mm)
        .number("refractive_index", object.refractive_index);
    if (object.mirror) table.line("material", quoted("mirror"));
    if (object.texture_image && object.texture.empty())
        throw std::invalid_argument("format_scene: object '" + object.name +
                                    "' has a texture from memory: expected its file");
    if (!object.texture.empty())
        table.line("texture", quoted(object.texture))
            .line("texture_size_mm", list(object.texture_size_mm));
}

void format_view(const SceneView& view, std::string& text) {
    TableText table(text, "[[view]]");
    table.line("name", quoted(view.name));
    std::string hidden;
    for (const std::string& name : view.hidden)
        hidden += (hidden.empty() ? "" : ", ") + quoted(name);
    if (!hidden.empty()) table.line("hidden", "[" + hidden + "]");
    for (const ViewPose& pose : view.poses)
        TableText(text, "[[view.pose]]")
            .line("object", quoted(pose.object))
            .line("world_from_object", list(pose.world_from_object));
}

}  // namespace

std::string format_scene(const Scene& scene) {
    std::string text = "seed = " + std::to_string(static_cast<std::int64_t>(scene.seed)) + "\n";
    TableText(text, "[scanner]").line("kind", quoted(name_of(scene.channel.axis.kind)));
    format_camera_and_sensor(scene, text);
    format_laser_and_axis(scene, text);
    TableText(text, "[ambient]")
        .number("level", scene.ambient_level)
        .number("flicker_hz", scene.flicker.hz)
        .number("flicker_depth", scene.flicker.depth);
    TableText(text, "[nominal]")
        .number("rotation_sigma_rad", scene.nominal.rotation_sigma_rad)
        .number("position_sigma_mm", scene.nominal.position_sigma_mm)
        .number("focal_relative_sigma", scene.nominal.focal_relative_sigma);
    TableText(text, "[fault]")
        .number("drop_frame_probability", scene.fault.drop_frame_probability)
        .number("duplicate_frame_probability", scene.fault.duplicate_frame_probability)
        .number("timing_jitter_us", scene.fault.timing_jitter_us)
        .number("interlock_opens_at_s", scene.fault.interlock_opens_at_s)
        .line("camera_stops_at_frame", std::to_string(scene.fault.camera_stops_at_frame));
    for (const SceneObject& object : scene.objects) format_object(object, text);
    for (const SceneView& view : scene.views) format_view(view, text);
    return text;
}

}  // namespace stria

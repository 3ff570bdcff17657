#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "host/core/errors.h"
#include "host/io/image_io.h"
#include "host/io/mesh_io.h"
#include "host/io/toml_file.h"
#include "host/io/whole_file.h"
#include "sim/scene.h"

namespace stria {
namespace {

Eigen::Vector3d vector3(TomlTable& table, const std::string& key) {
    const std::vector<double> v = table.numbers(key, 3);
    return {v[0], v[1], v[2]};
}

Eigen::Vector2d vector2(TomlTable& table, const std::string& key) {
    const std::vector<double> v = table.numbers(key, 2);
    return {v[0], v[1]};
}

/// A direction of any length, returned as a unit vector.
Eigen::Vector3d direction(TomlTable& table, const std::string& key) {
    const Eigen::Vector3d v = vector3(table, key);
    if (!(v.norm() > 1e-9) || !v.allFinite()) table.refuse(key, "expected a direction, found zero");
    return std::abs(v.norm() - 1) < 1e-12 ? v
                                          : v.normalized();  // written ones come back as they were
}

Rigid3 rigid(TomlTable& table, const std::string& key) {
    const std::vector<double> m = table.numbers(key, 16);
    Rigid3 motion;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            motion.rotation(row, column) = m[static_cast<std::size_t>(4 * row + column)];
        motion.translation[row] = m[static_cast<std::size_t>(4 * row + 3)];
    }
    if (!is_rigid(motion, 1e-4) || m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)
        table.refuse(key, "expected 16 numbers of a rigid motion, row by row");
    if (!is_rigid(motion, 1e-12)) motion.rotation = nearest_rotation(motion.rotation);
    return motion;
}

CameraModel parse_camera(TomlTable table) {
    CameraModel camera;
    const std::string model = table.text("model");
    const auto kind = lens_kind_from(model);
    if (!kind) table.refuse("model", "expected pinhole, brown5 or rational8, found " + model);
    camera.kind = *kind;
    camera.width = static_cast<int>(std::clamp<std::int64_t>(table.integer("width"), -1, 1 << 20));
    camera.height =
        static_cast<int>(std::clamp<std::int64_t>(table.integer("height"), -1, 1 << 20));
    camera.fx = table.number("fx");
    camera.fy = table.number("fy");
    camera.cx = table.number("cx");
    camera.cy = table.number("cy");
    const auto count = static_cast<std::size_t>(distortion_count(camera.kind));
    if (count > 0 || table.has("distortion")) {
        const std::vector<double> d = table.numbers("distortion");
        if (d.size() != count)
            table.refuse("distortion", "expected " + std::to_string(count) + " numbers, found " +
                                           std::to_string(d.size()));
        std::copy(d.begin(), d.end(), camera.distortion.begin());
    }
    if (const std::string why = validate(camera); !why.empty()) table.refuse("width", why);
    return camera;
}

SceneSensor parse_sensor(TomlTable table) {
    const SceneSensor usual;
    SceneSensor sensor;
    sensor.full_well_e = table.number("full_well_e", usual.full_well_e);
    sensor.read_noise_e = table.number("read_noise_e", usual.read_noise_e);
    sensor.gain_e_per_dn = table.number("gain_e_per_dn", usual.gain_e_per_dn);
    sensor.bits =
        static_cast<int>(std::clamp<std::int64_t>(table.integer("bits", usual.bits), 0, 99));
    sensor.exposure_us = table.number("exposure_us", usual.exposure_us);
    sensor.row_time_us = table.number("row_time_us", usual.row_time_us);
    sensor.black_dn = table.number("black_dn", usual.black_dn);
    sensor.min_frame_period_us = table.number("min_frame_period_us", usual.min_frame_period_us);
    sensor.pixel_um = table.number("pixel_um", usual.pixel_um);
    sensor.f_number = table.number("f_number", usual.f_number);
    sensor.quantum_efficiency = table.number("quantum_efficiency", usual.quantum_efficiency);
    sensor.noise = table.boolean("noise", usual.noise);
    sensor.prnu = table.number("prnu", usual.prnu);
    sensor.dsnu_e = table.number("dsnu_e", usual.dsnu_e);
    sensor.dark_current_e_per_s = table.number("dark_current_e_per_s", usual.dark_current_e_per_s);
    sensor.gamma = table.number("gamma", usual.gamma);
    return sensor;
}

SceneLens parse_lens(TomlTable table) {
    const SceneLens usual;
    SceneLens lens;
    lens.psf_sigma_px = table.number("psf_sigma_px", usual.psf_sigma_px);
    lens.focus_mm = table.number("focus_mm", usual.focus_mm);
    lens.cos4 = table.boolean("cos4", usual.cos4);
    lens.corner_loss = table.number("corner_loss", usual.corner_loss);
    return lens;
}

SceneReflection parse_reflection(TomlTable table) {
    SceneReflection reflection;
    reflection.bounce = table.boolean("bounce", reflection.bounce);
    reflection.mirrors = table.boolean("mirrors", reflection.mirrors);
    return reflection;
}

void parse_laser(TomlTable table, Scene& scene) {
    LaserSheet sheet;
    sheet.apex = vector3(table, "apex");
    sheet.central_ray = direction(table, "central_ray");
    sheet.normal = direction(table, "normal");
    sheet.offset_mm = sheet.normal.dot(sheet.apex);
    if (sheet.normal.cross(sheet.central_ray).norm() < 0.1)
        table.refuse("normal", "expected a vector across central_ray");
    sheet.wavelength_nm = table.number("wavelength_nm", sheet.wavelength_nm);
    sheet.waist_sigma_mm = table.number("waist_sigma_mm");
    sheet.waist_at_mm = table.number("waist_at_mm");
    sheet.fan_rad = table.number("fan_rad");
    sheet.bow2 = table.number("bow2", 0);
    sheet.bow3 = table.number("bow3", 0);
    scene.laser_power_mw = table.number("power_mw");
    scene.channel.sheet = normalised(sheet);
}

/// Moves the stated point of the axis to the one nearest the camera centre; the plane stays.
void settle_point(MirrorAxis& mirror) {
    const Eigen::Vector3d along = mirror.direction.dot(mirror.point) * mirror.direction;
    mirror.offset_mm += mirror.normal0.dot(along);
    mirror.point -= along;
}

void parse_axis(TomlTable table, Scene& scene) {
    AxisModel& model = scene.channel.axis;
    switch (model.kind) {
        case MachineKind::swept:
            model.mirror.direction = direction(table, "direction");
            model.mirror.point = vector3(table, "point");
            model.mirror.normal0 = direction(table, "normal0");
            model.mirror.offset_mm = table.number("offset_mm", 0);
            model.mirror.g2 = table.number("g2", 0);
            model.mirror.g3 = table.number("g3", 0);
            settle_point(model.mirror);
            break;
        case MachineKind::rail:
            model.rail.direction = direction(table, "direction");
            break;
        case MachineKind::turntable:
            model.turntable.table_from_camera = rigid(table, "table_from_camera");
            break;
    }
    model.delay_ns = table.number("delay_ns", 0);
    scene.axis.min = table.number("min");
    scene.axis.max = table.number("max");
    scene.axis.max_speed = table.number("max_speed");
    scene.axis.sigma = table.number("sigma", 0);
    scene.axis.log_period_us = table.number("log_period_us", SceneAxis{}.log_period_us);
    scene.axis.periodic_error = table.number("periodic_error", 0);
    scene.axis.periodic_length = table.number("periodic_length", SceneAxis{}.periodic_length);
    scene.axis.lag_us = table.number("lag_us", 0);
}

std::string beside(const std::string& base_dir, const std::string& file) {
    const std::filesystem::path path(file);
    return path.is_absolute() ? file : (std::filesystem::path(base_dir) / path).string();
}

void parse_shape(TomlTable& table, SceneObject& object, const std::string& base_dir) {
    const std::string shape = table.text("shape");
    if (shape == "sphere") {
        object.shape = SceneShape::sphere;
        object.radius_mm = table.number("radius");
    } else if (shape == "plane") {
        object.shape = SceneShape::plane;
        object.size_mm = vector2(table, "size");
        object.corner_mm =
            table.has("corner") ? vector2(table, "corner") : Eigen::Vector2d(-object.size_mm / 2);
    } else if (shape == "mesh") {
        object.shape = SceneShape::mesh;
        object.file = table.text("file");
        object.mm_per_unit = mm_per_unit(table.text("unit", "mm"));
        object.mesh = std::make_shared<const TriMesh>(
            read_mesh(beside(base_dir, object.file), {.mm_per_unit = object.mm_per_unit}));
    } else {
        table.refuse("shape", "expected sphere, plane or mesh, found " + shape);
    }
}

SceneObject parse_object(TomlTable& table, std::size_t number, const std::string& base_dir) {
    SceneObject object;
    object.name = table.text("name", "object" + std::to_string(number));
    parse_shape(table, object, base_dir);
    if (table.has("world_from_object"))
        object.world_from_object = rigid(table, "world_from_object");
    object.albedo = table.number("albedo", object.albedo);
    object.roughness_rad = table.number("roughness", object.roughness_rad);
    const std::string material = table.text("material", "diffuse");
    if (material != "diffuse" && material != "mirror")
        table.refuse("material", "expected diffuse or mirror, found " + material);
    object.mirror = material == "mirror";
    object.specular = table.number("specular", object.specular);
    object.gloss = table.number("gloss", object.gloss);
    if (table.has("texture")) {
        object.texture = table.text("texture");
        object.texture_size_mm = vector2(table, "texture_size_mm");
        object.texture_image =
            std::make_shared<const GreyImage>(read_grey_image(beside(base_dir, object.texture)));
    }
    return object;
}

SceneView parse_view(TomlTable& table, std::size_t number) {
    SceneView view;
    view.name = table.text("name", "view" + std::to_string(number));
    if (table.has("hidden")) view.hidden = table.texts("hidden");
    for (TomlTable& pose : table.tables("pose"))
        view.poses.push_back({pose.text("object"), rigid(pose, "world_from_object")});
    return view;
}

void parse_extras(TomlTable& root, Scene& scene) {
    if (auto table = root.find_table("ambient")) {
        scene.ambient_level = table->number("level");
        scene.flicker.hz = table->number("flicker_hz", scene.flicker.hz);
        scene.flicker.depth = table->number("flicker_depth", scene.flicker.depth);
    }
    if (auto table = root.find_table("nominal")) {
        SceneNominal& nominal = scene.nominal;
        nominal.rotation_sigma_rad =
            table->number("rotation_sigma_rad", nominal.rotation_sigma_rad);
        nominal.position_sigma_mm = table->number("position_sigma_mm", nominal.position_sigma_mm);
        nominal.focal_relative_sigma =
            table->number("focal_relative_sigma", nominal.focal_relative_sigma);
    }
    if (auto table = root.find_table("fault")) {
        SceneFault& fault = scene.fault;
        fault.drop_frame_probability = table->number("drop_frame_probability", 0);
        fault.duplicate_frame_probability = table->number("duplicate_frame_probability", 0);
        fault.timing_jitter_us = table->number("timing_jitter_us", 0);
        fault.interlock_opens_at_s = table->number("interlock_opens_at_s", -1);
        fault.camera_stops_at_frame = table->integer("camera_stops_at_frame", -1);
    }
}

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
        .number("bow3", sheet.bow3);
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
        .number("gloss", object.gloss);
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

Scene parse_scene(const std::string& text, const std::string& name, const std::string& base_dir) {
    TomlTable root = parse_toml(text, name);
    Scene scene;
    scene.seed = static_cast<std::uint64_t>(root.integer("seed", 1));
    TomlTable scanner = root.table("scanner");
    const std::string kind = scanner.text("kind");
    const auto machine = machine_kind_from(kind);
    if (!machine) scanner.refuse("kind", "expected swept, rail or turntable, found " + kind);
    scene.channel.axis.kind = *machine;
    scene.channel.camera = parse_camera(root.table("camera"));
    if (auto sensor = root.find_table("sensor")) scene.sensor = parse_sensor(std::move(*sensor));
    if (auto lens = root.find_table("lens")) scene.lens = parse_lens(std::move(*lens));
    if (auto reflection = root.find_table("reflection"))
        scene.reflection = parse_reflection(std::move(*reflection));
    parse_laser(root.table("laser"), scene);
    parse_axis(root.table("axis"), scene);
    for (TomlTable& object : root.tables("object"))
        scene.objects.push_back(parse_object(object, scene.objects.size() + 1, base_dir));
    for (TomlTable& view : root.tables("view"))
        scene.views.push_back(parse_view(view, scene.views.size() + 1));
    parse_extras(root, scene);
    root.finish();
    if (const std::string why = validate(scene); !why.empty()) throw FileError(name, "", why);
    return scene;
}

Scene read_scene(const std::string& path) {
    constexpr std::size_t kMaxSceneBytes = std::size_t{16} << 20;
    return parse_scene(read_whole_file(path, kMaxSceneBytes), path,
                       std::filesystem::path(path).parent_path().string());
}

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

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "host/core/errors.h"
#include "host/io/camera_toml.h"
#include "host/io/image_io.h"
#include "host/io/mesh_io.h"
#include "host/io/toml_file.h"
#include "host/io/whole_file.h"
#include "sim/scanner_preset.h"
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

ScannerPreset parse_preset(TomlTable& root) {
    if (!root.has("preset")) return {};
    const std::string name = root.text("preset");
    const auto preset = scanner_preset(name);
    if (!preset) root.refuse("preset", "expected " + scanner_preset_names() + ", found " + name);
    return *preset;
}

/// What the table does not say is as in `usual`.
SceneSensor parse_sensor(TomlTable table, const SceneSensor& usual) {
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
    sensor.cut_edges = table.boolean("cut_edges", usual.cut_edges);
    sensor.blooming = table.number("blooming", usual.blooming);
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

SceneSpeckle parse_speckle(TomlTable table) {
    SceneSpeckle speckle;
    const std::string model = table.text("model");
    const auto found = std::find_if(kSpeckleModels.begin(), kSpeckleModels.end(),
                                    [&](SpeckleModel known) { return model == name_of(known); });
    if (found == kSpeckleModels.end())
        table.refuse("model", "expected none, surface or screen, found " + model);
    speckle.model = *found;
    speckle.contrast = table.number("contrast", speckle.contrast);
    speckle.length_mm = table.number("length_mm", speckle.length_mm);
    return speckle;
}

void parse_laser(TomlTable table, Scene& scene) {
    LaserSheet sheet;
    sheet.wavelength_nm = scene.channel.sheet.wavelength_nm;
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
    SceneLine& line = scene.line;
    line.ripple = table.number("ripple", line.ripple);
    line.ripple_rad = table.number("ripple_rad", line.ripple_rad);
    line.falloff_rad = table.number("falloff_rad", line.falloff_rad);
    line.m2 = table.number("m2", line.m2);
    line.lobe = table.number("lobe", line.lobe);
    line.lobe_shift = table.number("lobe_shift", line.lobe_shift);
    if (sheet.offset_mm < 0) line.lobe_shift = 0 - line.lobe_shift;  // as normalised() turns it
    line.ghost = table.number("ghost", line.ghost);
    line.ghost_rad = table.number("ghost_rad", line.ghost_rad);
    if (auto speckle = table.find_table("speckle"))
        scene.speckle = parse_speckle(std::move(*speckle));
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
    scene.axis.wobble = table.number("wobble", 0);
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
    object.subsurface = table.number("subsurface", object.subsurface);
    object.free_path_mm = table.number("free_path_mm", object.free_path_mm);
    object.refractive_index = table.number("refractive_index", object.refractive_index);
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

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name, const std::string& base_dir) {
    TomlTable root = parse_toml(text, name);
    Scene scene;
    scene.seed = static_cast<std::uint64_t>(root.integer("seed", 1));
    const ScannerPreset preset = parse_preset(root);
    TomlTable scanner = root.table("scanner");
    const std::string kind = scanner.text("kind");
    const auto machine = machine_kind_from(kind);
    if (!machine) scanner.refuse("kind", "expected swept, rail or turntable, found " + kind);
    scene.channel.axis.kind = *machine;
    TomlTable camera = root.table("camera");
    scene.channel.camera = read_camera_keys(camera);
    scene.sensor = preset.sensor;
    if (auto sensor = root.find_table("sensor"))
        scene.sensor = parse_sensor(std::move(*sensor), preset.sensor);
    if (auto lens = root.find_table("lens")) scene.lens = parse_lens(std::move(*lens));
    if (auto reflection = root.find_table("reflection"))
        scene.reflection = parse_reflection(std::move(*reflection));
    scene.channel.sheet.wavelength_nm = preset.wavelength_nm;
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

}  // namespace stria

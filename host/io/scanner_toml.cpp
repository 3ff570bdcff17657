#include "host/core/errors.h"
#include "host/io/camera_toml.h"
#include "host/io/certificate_keys.h"
#include "host/io/model_io.h"
#include "host/io/number_text.h"
#include "host/io/toml_text.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

// Every function that reads a table stands beside the one that writes it.

LaserSheet read_sheet(TomlTable table) {
    LaserSheet sheet;
    sheet.normal = read_unit_vector(table, "normal");
    sheet.offset_mm = table.number("offset_mm");
    sheet.apex = read_vector(table, "apex");
    sheet.central_ray = read_unit_vector(table, "central_ray");
    sheet.bow2 = table.number("bow2", 0.0);
    sheet.bow3 = table.number("bow3", 0.0);
    sheet.fan_rad = table.number("fan_rad", sheet.fan_rad);
    sheet.waist_sigma_mm = table.number("waist_sigma_mm", sheet.waist_sigma_mm);
    sheet.waist_at_mm = table.number("waist_at_mm", sheet.waist_at_mm);
    sheet.wavelength_nm = table.number("wavelength_nm", sheet.wavelength_nm);
    if (!(sheet.wavelength_nm > 0)) table.refuse("wavelength_nm", "expected above 0");
    if (!(sheet.fan_rad > 0)) table.refuse("fan_rad", "expected above 0");
    if (!(sheet.waist_sigma_mm > 0)) table.refuse("waist_sigma_mm", "expected above 0");
    return sheet;
}

std::string format_sheet(const LaserSheet& sheet) {
    return toml_line("normal", sheet.normal) + toml_line("offset_mm", sheet.offset_mm) +
           toml_line("apex", sheet.apex) + toml_line("central_ray", sheet.central_ray) +
           toml_line("bow2", sheet.bow2) + toml_line("bow3", sheet.bow3) +
           toml_line("fan_rad", sheet.fan_rad) + toml_line("waist_sigma_mm", sheet.waist_sigma_mm) +
           toml_line("waist_at_mm", sheet.waist_at_mm) +
           toml_line("wavelength_nm", sheet.wavelength_nm);
}

AxisModel read_axis(TomlTable table) {
    AxisModel axis;
    const std::string kind = table.text("kind");
    if (kind == "mirror") {
        axis.kind = MachineKind::swept;
        axis.mirror.direction = read_unit_vector(table, "direction");
        axis.mirror.point = read_vector(table, "point");
        axis.mirror.normal0 = read_unit_vector(table, "normal0");
        axis.mirror.offset_mm = table.number("offset_mm");
        axis.mirror.g2 = table.number("g2", 0.0);
        axis.mirror.g3 = table.number("g3", 0.0);
    } else if (kind == "rail") {
        axis.kind = MachineKind::rail;
        axis.rail.direction = read_unit_vector(table, "direction");
    } else if (kind == "turntable") {
        axis.kind = MachineKind::turntable;
        axis.turntable.table_from_camera = read_rigid(table, "table_from_camera");
    } else {
        table.refuse("kind", "expected mirror, rail or turntable, found '" + kind + "'");
    }
    axis.delay_ns = table.number("delay_ns", 0.0);
    return axis;
}

std::string format_axis(const AxisModel& axis) {
    std::string text;
    switch (axis.kind) {
        case MachineKind::swept:
            text = "kind = \"mirror\"\n" + toml_line("direction", axis.mirror.direction) +
                   toml_line("point", axis.mirror.point) +
                   toml_line("normal0", axis.mirror.normal0) +
                   toml_line("offset_mm", axis.mirror.offset_mm) + toml_line("g2", axis.mirror.g2) +
                   toml_line("g3", axis.mirror.g3);
            break;
        case MachineKind::rail:
            text = "kind = \"rail\"\n" + toml_line("direction", axis.rail.direction);
            break;
        case MachineKind::turntable:
            text = "kind = \"turntable\"\n" +
                   toml_matrix("table_from_camera", axis.turntable.table_from_camera);
            break;
    }
    return text + toml_line("delay_ns", axis.delay_ns);
}

Channel read_channel(TomlTable table) {
    const auto id = [&](const std::string& key) {
        const std::int64_t value = table.integer(key, 0);
        if (value < 0 || value > 255)
            table.refuse(key, "expected 0 to 255, found " + std::to_string(value));
        return static_cast<std::uint8_t>(value);
    };
    Channel channel;
    channel.camera_id = id("camera_id");
    channel.laser_id = id("laser_id");
    TomlTable camera = table.table("camera");
    channel.camera = read_camera_keys(camera);
    channel.sheet = read_sheet(table.table("sheet"));
    channel.axis = read_axis(table.table("axis"));
    return channel;
}

std::string format_channel(const Channel& channel) {
    return "[[channel]]\ncamera_id = " + std::to_string(channel.camera_id) +
           "\nlaser_id = " + std::to_string(channel.laser_id) + "\n\n[channel.camera]\n" +
           format_camera_keys(channel.camera) + "\n[channel.sheet]\n" +
           format_sheet(channel.sheet) + "\n[channel.axis]\n" + format_axis(channel.axis) + "\n";
}

Eigen::MatrixXd read_covariance(TomlTable table, const std::vector<std::string>& expected) {
    const std::vector<std::string> names = table.texts("names");
    for (std::size_t i = 0; i < std::min(names.size(), expected.size()); ++i)
        if (names[i] != expected[i])
            table.refuse("names", "expected '" + expected[i] + "' at place " + std::to_string(i) +
                                      ", found '" + names[i] + "'");
    if (names.size() != expected.size())
        table.refuse("names", "expected the model's " + std::to_string(expected.size()) +
                                  " parameters, found " + std::to_string(names.size()));
    const std::size_t n = expected.size();
    const std::vector<double> values = table.numbers("matrix", n * n);
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const auto size = static_cast<Eigen::Index>(n);
    return Eigen::Map<const RowMajor>(values.data(), size, size);
}

std::string format_covariance(const ScannerModel& model) {
    std::string text = "[covariance]\nnames = [\n";
    for (const std::string& name : parameter_names(model)) text += "    " + toml_text(name) + ",\n";
    return text + "]\n" + toml_matrix("matrix", model.covariance) + "\n";
}

Provenance read_provenance(TomlTable table) {
    Provenance provenance;
    provenance.made_by = table.text("made_by", "");
    provenance.date = table.text("date", "");
    provenance.data_hash = table.text("data_hash", "");
    provenance.rms_px = table.number("rms_px", 0.0);
    return provenance;
}

std::string format_provenance(const Provenance& provenance) {
    return "[provenance]\nmade_by = " + toml_text(provenance.made_by) +
           "\ndate = " + toml_text(provenance.date) +
           "\ndata_hash = " + toml_text(provenance.data_hash) + "\n" +
           toml_line("rms_px", provenance.rms_px) + "\n";
}

}  // namespace

ScannerModel parse_scanner(const std::string& text, const std::string& name) {
    TomlTable top = parse_toml(text, name);
    ScannerModel model;
    for (TomlTable& channel : top.tables("channel"))
        model.channels.push_back(read_channel(std::move(channel)));
    if (auto table = top.find_table("provenance"))
        model.provenance = read_provenance(std::move(*table));
    if (auto table = top.find_table("volume")) {
        model.volume.min = read_vector(*table, "min");
        model.volume.max = read_vector(*table, "max");
    }
    if (auto table = top.find_table("covariance"))
        model.covariance = read_covariance(std::move(*table), parameter_names(model));
    // Checked like the rest, but no part of the model: read_certificate() returns it.
    if (auto table = top.find_table("certificate")) read_certificate_keys(*table);
    top.finish();
    if (const std::string why = validate(model); !why.empty()) throw FileError(name, "", why);
    return model;
}

std::string format_scanner(const ScannerModel& model) {
    std::string text = format_provenance(model.provenance);
    for (const Channel& channel : model.channels) text += format_channel(channel);
    if (!model.volume.is_empty())
        text += "[volume]\n" + toml_line("min", model.volume.min) +
                toml_line("max", model.volume.max) + "\n";
    if (model.covariance.size() != 0) text += format_covariance(model);
    return text;
}

ScannerModel read_scanner(const std::string& path) {
    return parse_scanner(read_whole_file(path, std::size_t{64} << 20), path);
}

void write_scanner(const std::string& path, const ScannerModel& model) {
    write_whole_file(path, format_scanner(model));
}

}  // namespace stria

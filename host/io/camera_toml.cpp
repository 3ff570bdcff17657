#include "host/io/camera_toml.h"

#include <algorithm>
#include <span>

#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/io/number_text.h"
#include "host/io/toml_text.h"
#include "host/io/whole_file.h"

namespace stria {

CameraModel read_camera_keys(TomlTable& table) {
    CameraModel camera;
    const std::string model = table.text("model");
    const auto kind = lens_kind_from(model);
    if (!kind)
        table.refuse("model", "expected pinhole, brown5 or rational8, found '" + model + "'");
    camera.kind = *kind;
    const auto side = [&](const std::string& key) {
        const std::int64_t value = table.integer(key);
        if (value < 1 || value > 16384)
            table.refuse(key, "expected 1 to 16384, found " + std::to_string(value));
        return static_cast<int>(value);
    };
    camera.width = side("width");
    camera.height = side("height");
    camera.fx = table.number("fx");
    camera.fy = table.number("fy");
    camera.cx = table.number("cx");
    camera.cy = table.number("cy");
    const auto count = static_cast<std::size_t>(distortion_count(camera.kind));
    if (count > 0 || table.has("distortion")) {
        const std::vector<double> values = table.numbers("distortion");
        if (values.size() != count)
            table.refuse("distortion", "expected the " + std::to_string(count) + " numbers of " +
                                           model + ", found " + std::to_string(values.size()));
        std::copy(values.begin(), values.end(), camera.distortion.begin());
    }
    if (const std::string why = validate(camera); !why.empty())
        table.refuse(why.substr(0, why.find(' ')), why);
    return camera;
}

std::string format_camera_keys(const CameraModel& camera) {
    std::string text = "model = " + toml_text(name_of(camera.kind)) + "\n";
    text += "width = " + std::to_string(camera.width) + "\n";
    text += "height = " + std::to_string(camera.height) + "\n";
    text += "fx = " + toml_number(camera.fx) + "\nfy = " + toml_number(camera.fy) + "\n";
    text += "cx = " + toml_number(camera.cx) + "\ncy = " + toml_number(camera.cy) + "\n";
    const auto count = static_cast<std::size_t>(distortion_count(camera.kind));
    return text + toml_line("distortion", std::span<const double>(camera.distortion.data(), count));
}

CameraModel parse_camera(const std::string& text, const std::string& name) {
    TomlTable top = parse_toml(text, name);
    TomlTable table = top.table("camera");
    const CameraModel camera = read_camera_keys(table);
    top.finish();
    return camera;
}

CameraModel read_camera(const std::string& path) {
    return parse_camera(read_whole_file(path, std::size_t{1} << 20), path);
}

std::string format_camera(const CameraModel& camera) {
    return "[camera]\n" + format_camera_keys(camera);
}

void write_camera(const std::string& path, const CameraModel& camera) {
    write_whole_file(path, format_camera(camera));
}

}  // namespace stria

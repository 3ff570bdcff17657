#pragma once
#include <string>

#include "host/core/camera_model.h"
#include "host/io/toml_file.h"

/// The camera's keys, wherever a table holds a camera.
namespace stria {

/// Reads the table's keys of camera.toml (model, width, height, fx, fy, cx, cy, distortion) and
/// leaves others, which the caller may ask for. Refuses what validate() does.
CameraModel read_camera_keys(TomlTable& table);
/// Those keys as lines, without the table's header.
std::string format_camera_keys(const CameraModel& camera);

}  // namespace stria

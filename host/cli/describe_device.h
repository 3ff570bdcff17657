#pragma once
#include <string>

#include "firmware/protocol/messages.h"
#include "host/cli/json_result.h"

namespace stria {

/// A device's description as JSON: model, serial, camera, axis.
JsonResult json_of(const DeviceDescription& device);
/// A feature as JSON: name, value, unit, access, min, max, limit_reason, description.
JsonResult json_of(const Feature& feature);

/// The plan of a run in JSON.
JsonResult json_of(const ScanPlan& plan);

/// "ExposureTime = 1000 us  [1 .. 10000000: shortest and longest exposure of the camera]".
std::string line_of(const Feature& feature);

}  // namespace stria

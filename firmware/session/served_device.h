#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "firmware/acquire/acquire.h"
#include "firmware/devices/devices.h"
#include "firmware/protocol/messages.h"

namespace stria {

/// A feature and what stands behind it. `read` gives it with its present value and range; an empty
/// `write` makes it read-only. Both are called one at a time, `write` never during a run.
struct DeviceFeature {
    std::function<Feature()> read;
    std::function<Status(const FeatureValue&)> write;
};

/// A machine as a session serves it.
struct ServedDevice {
    explicit ServedDevice(Devices parts) : devices(std::move(parts)) {}

    Devices devices;  ///< borrowed for the session's life
    std::string model_name;
    std::string serial;
    std::string firmware_version;
    std::string kind = "swept";  ///< swept | rail | turntable
    bool simulated = false;
    std::string model_text;  ///< scanner.toml of the nominal model, may be empty
    AcquireOptions acquire;  ///< exposure_ns and frame_period_ns: where the features start
    std::vector<DeviceFeature> further_features;
};

/// What the device says about itself, from its parts' own info.
DeviceDescription describe(const ServedDevice& device);

}  // namespace stria

#pragma once
#include <memory>
#include <string>

#include "host/link/device_client.h"

namespace stria {

struct OpenOptions {
    ConnectOptions connect;
    unsigned seed = 1;  ///< of simulated devices, mixed with the scene's own
    int threads = 1;    ///< stripe analysis of simulated devices
};

/// Opens any DEVICE: "sim:SCENE.toml" ("sim:" alone is the built-in scene) runs a simulated scanner
/// and its session in this process, joined to the client by in-memory streams, so that the same
/// protocol is spoken; everything else goes to connect_device().
std::unique_ptr<DeviceClient> open_device(const std::string& uri, const OpenOptions& options = {});

}  // namespace stria

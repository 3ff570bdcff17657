#include "sim/striad_sim/served_scanner.h"

#include <cmath>
#include <exception>

namespace stria {
namespace {

DeviceFeature scene_view(SimulatedScanner& scanner) {
    const auto read = [&scanner] {
        return Feature{
            "SceneView",
            "",
            "Which view of the scene stands before the scanner.",
            std::int64_t{scanner.view()},
            Access::read_write,
            FeatureRange{0.0, static_cast<double>(scanner.view_count() - 1), "views of the scene"}};
    };
    const auto write = [&scanner](const FeatureValue& value) -> Status {
        try {
            scanner.set_view(static_cast<int>(std::get<std::int64_t>(value)));
        } catch (const std::exception& error) {
            return Failure{error.what()};
        }
        return {};
    };
    return {read, write};
}

}  // namespace

ServedDevice served_scanner(SimulatedScanner& scanner, int threads) {
    const Scene& scene = scanner.scene();
    ServedDevice device(scanner.devices());
    device.model_name = "stria simulated scanner";
    device.serial = "sim-" + std::to_string(scene.seed);
    device.firmware_version = STRIA_VERSION;
    device.kind = name_of(scene.channel.axis.kind);
    device.simulated = true;
    device.model_text = scanner.nominal_model_text();
    device.acquire.spacetime_per_pixel = scene.channel.axis.kind == MachineKind::swept;
    device.acquire.exposure_ns = std::llround(scene.sensor.exposure_us * 1e3);
    device.acquire.spatial.threads = threads;
    device.acquire.spacetime.threads = threads;
    device.acquire.paths.threads = threads;
    device.further_features.push_back(scene_view(scanner));
    return device;
}

}  // namespace stria

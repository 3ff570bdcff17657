#pragma once
#include <memory>

#include "host/link/device_client.h"
#include "host/local/open_device.h"
#include "sim/simulated_scanner.h"

namespace stria {

/// A simulated scanner, its session on threads of their own, and a client of it, joined by
/// in-memory streams: the `sim:` device, with the scanner itself at hand for comparison with the
/// truth.
class LocalScanner : public DeviceClient {
  public:
    /// Throws std::invalid_argument where validate(scene) complains.
    explicit LocalScanner(const Scene& scene, const OpenOptions& options = {});
    ~LocalScanner() override;

    Snapshot info() override;
    std::vector<Feature> features() override;
    Feature feature(const std::string& name) override;
    Feature set_feature(const std::string& name, const FeatureValue& value) override;
    void set_paths(const std::vector<PathTable>& tables) override;
    RecordingContents run(const ScanPlan& plan, const RunOptions& options = {}) override;

    /// Not while a run is going on.
    SimulatedScanner& scanner();

  private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace stria

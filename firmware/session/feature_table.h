#pragma once
#include <string>
#include <vector>

#include "firmware/session/served_device.h"

namespace stria {

/// Features by name.
class FeatureTable {
  public:
    explicit FeatureTable(std::vector<DeviceFeature> features);

    std::vector<Feature> all() const;
    /// Fails on an unknown name and names the nearest one.
    Result<Feature> get(const std::string& name) const;
    /// The feature as it then is. Fails with the reason: unknown, read only, wrong type, outside
    /// its range (with the limit's reason), or the device's own.
    Result<Feature> set(const std::string& name, const FeatureValue& value);

  private:
    Result<const DeviceFeature*> find(const std::string& name) const;
    std::vector<DeviceFeature> features_;
};

/// The features that every device has, reading and writing `options`: names of SFNC 2.7 where it
/// has them. Both references must outlive the table. LaserPower is the greatest power that a plan
/// may ask for.
struct DeviceSettings {
    AcquireOptions acquire;
    double laser_power = 1.0;
};
std::vector<DeviceFeature> common_features(const ServedDevice& device, DeviceSettings& settings);

/// Empty if the SIMD kernels can analyse this machine's sweeps in spacetime
/// (SpacetimeOptions::fast), else why the reference does: frames of more than 8 bits, image paths.
std::string why_not_fast(const CameraInfo& camera, const AcquireOptions& options);

}  // namespace stria

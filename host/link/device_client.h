#pragma once
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/protocol/messages.h"
#include "host/link/recording_contents.h"

namespace stria {

/// How far a run has come, as the device's health messages say it.
struct RunProgress {
    std::uint32_t frames = 0;           ///< laser-on frames taken
    std::uint32_t frames_expected = 0;  ///< that the plan asks for
    std::uint32_t frames_dropped = 0;
    bool laser_on = false;
};

struct RunOptions {
    std::string recording_path;                        ///< empty: nothing is written
    LoadOptions load;                                  ///< what becomes of the frames
    std::function<void(const RunProgress&)> progress;  ///< called on the caller's thread
};

/// A device as the host sees it, whatever lies between. Every call blocks, and throws DeviceError
/// with the device's own reason, or after the time that ConnectOptions states when it does not
/// answer. Not for use by several threads at once.
class DeviceClient {
  public:
    virtual ~DeviceClient() = default;
    /// The device, its clock, features and nominal scanner model.
    virtual Snapshot info() = 0;
    virtual std::vector<Feature> features() = 0;
    virtual Feature feature(const std::string& name) = 0;
    /// The feature as the device then has it. Throws DeviceError where the device refuses: unknown
    /// name, outside its range (with the reason), read only, or another client has control.
    virtual Feature set_feature(const std::string& name, const FeatureValue& value) = 0;
    /// The image paths that runs in spacetime follow on a rail or turntable, one table a laser
    /// (host/scan/path_table.h); they replace what was sent before, and the device forgets them
    /// when this client goes. Throws DeviceError where the device refuses: its pixels are surface
    /// points, another image size or laser, firmware that knows no paths.
    virtual void set_paths(const std::vector<PathTable>& tables) = 0;
    /// Carries out a plan. A run that the device ends early still returns what it brought, with
    /// end->reason; a link that breaks throws, and the recording keeps what had come.
    virtual RecordingContents run(const ScanPlan& plan, const RunOptions& options = {}) = 0;
};

struct ConnectOptions {
    std::string client_name = "stria";
    bool control = true;                      ///< false: watch only
    std::chrono::milliseconds timeout{5000};  ///< for every answer
};

/// Opens "unix:PATH", "tcp:HOST:PORT" (loopback) or "replay:FILE". Throws stria::Error that names
/// the kinds there are; DeviceError if nothing answers. For "sim:" see host/local.
std::unique_ptr<DeviceClient> connect_device(const std::string& uri,
                                             const ConnectOptions& options = {});

/// `text` as a value of that feature's type. Throws stria::Error that says what was expected.
FeatureValue parse_feature_value(const Feature& feature, const std::string& text);
/// The value as text for people: numbers as short as they can be exact.
std::string to_string(const FeatureValue& value);

}  // namespace stria

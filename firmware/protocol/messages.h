#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "firmware/core/axis_log.h"
#include "firmware/core/frame.h"
#include "firmware/core/image_paths.h"
#include "firmware/core/pulse.h"
#include "firmware/core/scan_plan.h"
#include "firmware/core/sensor_noise.h"
#include "firmware/core/time.h"

/// Plain structs of everything that crosses the wire beside Frame and AxisLog.
namespace stria {

using FeatureValue = std::variant<std::int64_t, double, std::string, bool>;

enum class Access : std::uint8_t { read = 0, read_write = 1 };

/// What a feature's value may be, and what sets the limit.
struct FeatureRange {
    double min = 0;
    double max = 0;
    std::string reason;
    bool operator==(const FeatureRange&) const = default;
};

/// A named setting or reading; SFNC's name where that has one.
struct Feature {
    std::string name;
    std::string unit;  ///< empty: a number without unit, or text
    std::string description;
    FeatureValue value;
    Access access = Access::read;
    std::optional<FeatureRange> range;  ///< of numbers; false and true are 0 and 1
    bool operator==(const Feature&) const = default;
};

/// What kind of machine answers.
struct DeviceDescription {
    std::string model_name;
    std::string serial;
    std::string firmware_version;
    std::string kind = "swept";  ///< swept | rail | turntable
    bool simulated = false;
    std::string camera_name;
    int width = 0;
    int height = 0;
    int bits = 8;
    SensorNoise noise;
    TimeNs row_time_ns = 0;
    TimeNs min_frame_period_ns = 0;
    TimeNs min_exposure_ns = 0;
    TimeNs max_exposure_ns = 0;
    TimeNs timestamp_sigma_ns = 0;
    std::string axis_name;
    double axis_min = 0, axis_max = 0;  ///< mm or rad
    double axis_max_speed = 0;          ///< per second
    double axis_sigma = 0;
    int lasers = 1;
};

/// Opens a run on the data channel, and thereby a recording.
struct Snapshot {
    int protocol_version = 1;
    TimeNs clock_ns = 0;  ///< device clock when the run began
    DeviceDescription device;
    std::vector<Feature> features;
    ScanPlan plan;
    std::string model_text;  ///< scanner.toml of the nominal model if known, else empty
};

/// Rows first_row .. first_row + map.height - 1 of a pulse map of full_height rows; pulses keep
/// the numbers they have in the whole map.
struct PulseBand {
    PulseMap map;
    int first_row = 0;
    int full_height = 0;
};

enum class DeviceState : std::uint8_t { idle = 0, running = 1, stopped = 2, failed = 3 };

struct Health {
    TimeNs t_ns = 0;  ///< device clock
    DeviceState state = DeviceState::idle;
    bool laser_on = false;
    bool interlock_closed = false;
    double emission_s = 0;  ///< laser on, this run
    std::uint32_t frames = 0;
    std::uint32_t frames_dropped = 0;
    std::string message;
    bool operator==(const Health&) const = default;
};

/// Last message of a run.
struct End {
    bool complete = false;  ///< every frame of the plan was taken
    std::string reason;     ///< why not; empty if complete
    std::uint32_t frames = 0;
    std::uint32_t frames_dropped = 0;
    double emission_s = 0;
    bool operator==(const End&) const = default;
};

enum class Role : std::uint8_t { watch = 0, control = 1 };

enum class RequestVerb : std::uint8_t {
    hello = 0,        ///< client, role
    describe = 1,     ///< answered with a snapshot
    features = 2,     ///< name, or empty for all
    set_feature = 3,  ///< name, value
    start = 4,        ///< plan
    stop = 5,
    heartbeat = 6,
    credit = 7,  ///< credit_bytes more of data may be sent; not answered
    ack = 8,     ///< run is safe on the client's disk
    select = 9,  ///< channels
    /// paths: kept for its laser, in the place of what was; without paths all are forgotten
    set_paths = 10,
};
constexpr int kLastRequestVerb = static_cast<int>(RequestVerb::set_paths);

constexpr std::uint8_t kSelectData = 1;
constexpr std::uint8_t kSelectHealth = 2;

struct Request {
    std::uint32_t id = 0;  ///< chosen by the client, repeated in the response
    RequestVerb verb = RequestVerb::heartbeat;
    std::string client = {};
    Role role = Role::watch;
    std::string name = {};
    FeatureValue value = {};
    std::optional<ScanPlan> plan = {};
    std::uint64_t credit_bytes = 0;
    std::uint32_t run = 0;
    std::uint8_t channels = 0;  ///< sum of kSelect...
    std::optional<PathTable> paths = {};
};

struct Response {
    std::uint32_t id = 0;
    bool ok = true;
    std::string error;
    Role role = Role::watch;  ///< that the client has
    std::uint32_t run = 0;    ///< start: the number of the run
    std::optional<Snapshot> snapshot;
    std::vector<Feature> features;
};

using Message =
    std::variant<Snapshot, Frame, AxisLog, PulseBand, PathTable, Health, End, Request, Response>;

}  // namespace stria

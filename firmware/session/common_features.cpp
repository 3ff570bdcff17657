#include <algorithm>
#include <cmath>

#include "firmware/session/feature_table.h"

namespace stria {
namespace {

double us_of(TimeNs time) { return static_cast<double>(time) * 1e-3; }

DeviceFeature fixed(Feature feature) {
    return {[feature] { return feature; }, {}};
}

DeviceFeature exposure_time(const CameraInfo& camera, DeviceSettings& settings) {
    const auto read = [camera, &settings] {
        return Feature{"ExposureTime",
                       "us",
                       "Exposure of a frame where the plan names none.",
                       us_of(settings.acquire.exposure_ns),
                       Access::read_write,
                       FeatureRange{us_of(camera.min_exposure_ns), us_of(camera.max_exposure_ns),
                                    "shortest and longest exposure of the camera"}};
    };
    const auto write = [&settings](const FeatureValue& value) -> Status {
        settings.acquire.exposure_ns = std::llround(std::get<double>(value) * 1e3);
        return {};
    };
    return {read, write};
}

DeviceFeature frame_rate(const CameraInfo& camera, DeviceSettings& settings) {
    const auto shortest = [camera, &settings] {
        return std::max(camera.min_frame_period_ns, settings.acquire.exposure_ns);
    };
    const auto read = [camera, shortest, &settings] {
        const double greatest = 1e9 / static_cast<double>(shortest());
        const TimeNs period = std::max(shortest(), settings.acquire.frame_period_ns);
        const bool by_exposure = settings.acquire.exposure_ns > camera.min_frame_period_ns;
        return Feature{"AcquisitionFrameRate",
                       "Hz",
                       "Frames a second during a sweep; a slow axis may ask for fewer.",
                       1e9 / static_cast<double>(period),
                       Access::read_write,
                       FeatureRange{0.1, greatest,
                                    by_exposure ? "a frame takes as long as its ExposureTime"
                                                : "the camera's shortest frame period"}};
    };
    const auto write = [shortest, &settings](const FeatureValue& value) -> Status {
        const TimeNs period = std::llround(1e9 / std::get<double>(value));
        settings.acquire.frame_period_ns = std::max(period, shortest());
        return {};
    };
    return {read, write};
}

DeviceFeature laser_power(DeviceSettings& settings) {
    const auto read = [&settings] {
        return Feature{"LaserPower",
                       "",
                       "Greatest laser power that a plan may ask for, as a share of full power.",
                       settings.laser_power,
                       Access::read_write,
                       FeatureRange{0.0, 1.0, "1 is the laser's full power"}};
    };
    const auto write = [&settings](const FeatureValue& value) -> Status {
        settings.laser_power = std::get<double>(value);
        return {};
    };
    return {read, write};
}

/// Whether pulses can be measured in spacetime, and why not.
DeviceFeature image_paths(const DeviceSettings& settings) {
    return {[&settings] {
                return Feature{"ImagePaths",
                               "",
                               "What spacetime analysis follows: pixels, or per laser the image "
                               "paths of the model with that hash.",
                               describe_paths(settings.acquire),
                               Access::read,
                               {}};
            },
            {}};
}

/// Whether the SIMD kernels analyse a sweep; its range says why they cannot.
DeviceFeature fast_spacetime(const CameraInfo& camera, DeviceSettings& settings) {
    const std::string why_not = why_not_fast(camera, settings.acquire);
    const auto read = [why_not, &settings] {
        return Feature{
            "FastSpacetime",
            "",
            "Whether SIMD kernels analyse sweeps of surface points in spacetime; else "
            "the slower reference does, whose pulses are the same within stated bounds.",
            settings.acquire.spacetime.fast && why_not.empty(),
            Access::read_write,
            FeatureRange{0.0, why_not.empty() ? 1.0 : 0.0,
                         why_not.empty() ? "samples of 8 bits: both are there" : why_not}};
    };
    const auto write = [&settings](const FeatureValue& value) -> Status {
        settings.acquire.spacetime.fast = std::get<bool>(value);
        return {};
    };
    return {read, write};
}

void add_axis(std::vector<DeviceFeature>& list, const AxisInfo& axis, const std::string& kind) {
    const std::string unit = kind == "rail" ? "mm" : "rad";
    list.push_back(fixed(
        {"AxisPositionMin", unit, "Least position of the axis.", axis.min_s, Access::read, {}}));
    list.push_back(fixed(
        {"AxisPositionMax", unit, "Greatest position of the axis.", axis.max_s, Access::read, {}}));
    list.push_back(fixed({"AxisSpeedMax",
                          unit + "/s",
                          "Greatest speed of the axis.",
                          axis.max_speed,
                          Access::read,
                          {}}));
}

}  // namespace

std::string why_not_fast(const CameraInfo& camera, const AcquireOptions& options) {
    if (camera.bits != 8)
        return "the kernels take samples of 8 bits; the reference analyses this camera's " +
               std::to_string(camera.bits);
    if (!options.spacetime_per_pixel)
        return "this machine moves the part; its pulses are followed along image paths";
    return "";
}

std::vector<DeviceFeature> common_features(const ServedDevice& device, DeviceSettings& settings) {
    const CameraInfo camera = device.devices.camera.info();
    std::vector<DeviceFeature> list;
    const auto add_text = [&](const char* name, const char* what, const std::string& value) {
        list.push_back(fixed({name, "", what, value, Access::read, {}}));
    };
    const auto add_whole = [&](const char* name, const char* unit, const char* what, int value) {
        list.push_back(fixed({name, unit, what, std::int64_t{value}, Access::read, {}}));
    };
    add_text("DeviceModelName", "Name of the model.", device.model_name);
    add_text("DeviceSerialNumber", "Serial number.", device.serial);
    add_text("DeviceFirmwareVersion", "Version of the firmware.", device.firmware_version);
    add_whole("Width", "px", "Columns of a frame.", camera.width);
    add_whole("Height", "px", "Rows of a frame.", camera.height);
    add_text("PixelFormat", "Samples of a frame.", "Mono" + std::to_string(camera.bits));
    list.push_back(exposure_time(camera, settings));
    list.push_back(frame_rate(camera, settings));
    list.push_back(laser_power(settings));
    list.push_back(image_paths(settings));
    list.push_back(fast_spacetime(camera, settings));
    add_axis(list, device.devices.axis.info(), device.kind);
    Interlock& interlock = device.devices.interlock;
    list.push_back(
        {[&interlock] {
             return Feature{
                 "InterlockClosed",     "",           "Whether the safety interlock is closed.",
                 interlock.is_closed(), Access::read, {}};
         },
         {}});
    for (const DeviceFeature& feature : device.further_features) list.push_back(feature);
    return list;
}

DeviceDescription describe(const ServedDevice& device) {
    const CameraInfo camera = device.devices.camera.info();
    const AxisInfo axis = device.devices.axis.info();
    DeviceDescription d;
    d.model_name = device.model_name;
    d.serial = device.serial;
    d.firmware_version = device.firmware_version;
    d.kind = device.kind;
    d.simulated = device.simulated;
    d.camera_name = camera.name;
    d.width = camera.width;
    d.height = camera.height;
    d.bits = camera.bits;
    d.noise = camera.noise;
    d.row_time_ns = camera.row_time_ns;
    d.min_frame_period_ns = camera.min_frame_period_ns;
    d.min_exposure_ns = camera.min_exposure_ns;
    d.max_exposure_ns = camera.max_exposure_ns;
    d.timestamp_sigma_ns = camera.timestamp_sigma_ns;
    d.axis_name = axis.name;
    d.axis_min = axis.min_s;
    d.axis_max = axis.max_s;
    d.axis_max_speed = axis.max_speed;
    d.axis_sigma = axis.sigma_s;
    d.lasers = 1 + static_cast<int>(device.devices.further_lasers.size());
    return d;
}

}  // namespace stria

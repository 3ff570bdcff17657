#include "host/cli/describe_device.h"

#include "host/link/device_client.h"

namespace stria {
namespace {

double ms(TimeNs time) { return static_cast<double>(time) * 1e-6; }
double us(TimeNs time) { return static_cast<double>(time) * 1e-3; }

void set_value(JsonResult& result, const FeatureValue& value) {
    if (const auto* number = std::get_if<double>(&value)) result.set("value", *number);
    if (const auto* flag = std::get_if<bool>(&value)) result.set("value", *flag);
    if (const auto* text = std::get_if<std::string>(&value)) result.set("value", *text);
    if (const auto* whole = std::get_if<std::int64_t>(&value))
        result.set("value", static_cast<double>(*whole));
}

}  // namespace

JsonResult json_of(const DeviceDescription& device) {
    const JsonResult camera = JsonResult()
                                  .set("name", device.camera_name)
                                  .set("width", device.width)
                                  .set("height", device.height)
                                  .set("bits", device.bits)
                                  .set("row_time_us", us(device.row_time_ns))
                                  .set("min_frame_period_ms", ms(device.min_frame_period_ns))
                                  .set("min_exposure_us", us(device.min_exposure_ns))
                                  .set("max_exposure_us", us(device.max_exposure_ns))
                                  .set("gain_e_per_dn", device.noise.gain_e_per_dn)
                                  .set("read_noise_e", device.noise.read_noise_e)
                                  .set("black_dn", device.noise.black_dn);
    const JsonResult axis = JsonResult()
                                .set("name", device.axis_name)
                                .set("unit", device.kind == "rail" ? "mm" : "rad")
                                .set("min", device.axis_min)
                                .set("max", device.axis_max)
                                .set("max_speed", device.axis_max_speed)
                                .set("sigma", device.axis_sigma);
    return JsonResult()
        .set("model_name", device.model_name)
        .set("serial", device.serial)
        .set("firmware_version", device.firmware_version)
        .set("kind", device.kind)
        .set("simulated", device.simulated)
        .set("lasers", device.lasers)
        .set("camera", camera)
        .set("axis", axis);
}

JsonResult json_of(const Feature& feature) {
    JsonResult result;
    result.set("name", feature.name);
    set_value(result, feature.value);
    result.set("unit", feature.unit)
        .set("access", feature.access == Access::read ? "read" : "read_write")
        .set("description", feature.description);
    if (feature.range)
        result.set("min", feature.range->min)
            .set("max", feature.range->max)
            .set("limit_reason", feature.range->reason);
    return result;
}

JsonResult json_of(const ScanPlan& plan) {
    return JsonResult()
        .set("mode", plan.mode == StripeMode::spatial ? "spatial" : "spacetime")
        .set("from", plan.from)
        .set("to", plan.to)
        .set("step", plan.step)
        .set("exposures_us", plan.exposures_us)
        .set("laser_power", plan.laser_power)
        .set("off_frames", plan.off_frames)
        .set("both_directions", plan.both_directions);
}

std::string line_of(const Feature& feature) {
    std::string line = feature.name + " = " + to_string(feature.value);
    if (!feature.unit.empty()) line += " " + feature.unit;
    if (feature.range)
        line += "  [" + to_string(FeatureValue(feature.range->min)) + " .. " +
                to_string(FeatureValue(feature.range->max)) + ": " + feature.range->reason + "]";
    if (feature.access == Access::read) line += "  (read only)";
    return line;
}

}  // namespace stria

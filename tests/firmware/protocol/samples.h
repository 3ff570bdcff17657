#pragma once
#include <cstring>
#include <random>
#include <vector>

#include "firmware/protocol/messages.h"

/// Messages with every field set, for round trips.
namespace stria::samples {

inline ScanPlan plan() {
    ScanPlan plan;
    plan.mode = StripeMode::spatial;
    plan.from = -0.25;
    plan.to = 0.5;
    plan.step = 0.001;
    plan.exposures_us = {500.0, 2000.0};
    plan.laser_power = 0.75;
    plan.lasers = {0, 2};
    plan.off_frames = 3;
    plan.off_exposure_us = 4000.0;
    plan.both_directions = true;
    plan.record = RecordWhat::both;
    plan.max_emission_s = 12.5;
    return plan;
}

inline std::vector<Feature> features() {
    return {{"ExposureTime", "us", "Exposure of a frame.", 1000.0, Access::read_write,
             FeatureRange{10.0, 20000.0, "frame period"}},
            {"DeviceModelName", "", "Name of the model.", std::string("sim"), Access::read, {}},
            {"SceneView", "", "View.", std::int64_t{7}, Access::read_write, {}},
            {"LaserOn", "", "Laser.", true, Access::read, {}}};
}

inline DeviceDescription device() {
    DeviceDescription device;
    device.model_name = "simulated scanner";
    device.serial = "0001";
    device.firmware_version = "0.1.0";
    device.kind = "turntable";
    device.simulated = true;
    device.camera_name = "camera";
    device.width = 64;
    device.height = 48;
    device.bits = 10;
    device.noise = {41.0, 11.0, 2.0};
    device.row_time_ns = 1;
    device.min_frame_period_ns = 2;
    device.min_exposure_ns = 3;
    device.max_exposure_ns = 4;
    device.timestamp_sigma_ns = 5;
    device.axis_name = "mirror";
    device.axis_min = -1.0;
    device.axis_max = 1.0;
    device.axis_max_speed = 3.0;
    device.axis_sigma = 1e-6;
    device.lasers = 3;
    return device;
}

inline Snapshot snapshot() {
    return {1, 123456789, device(), features(), plan(), "[[channel]]\ncamera_id = 0\n"};
}

inline Frame frame(int width = 7, int height = 5, int bits = 8, unsigned seed = 1) {
    Frame frame;
    resize(frame, width, height, bits);
    std::mt19937 rng(seed);
    for (auto& byte : frame.bytes) byte = static_cast<std::uint8_t>(rng() & 3U);
    frame.camera_id = 1;
    frame.laser_id = 2;
    frame.exposure_index = 1;
    frame.laser_power = 0.5F;
    frame.exposure_start_ns = 5'000'000'000;
    frame.exposure_ns = 1'000'000;
    frame.row_time_ns = 10'000;
    frame.sequence = 99;
    return frame;
}

inline AxisLog axis_log(int samples = 5) {
    AxisLog log;
    log.sigma_s = 1e-5;
    for (int i = 0; i < samples; ++i) log.samples.push_back({1000 * i + i, 0.25 * i});
    return log;
}

/// Random cells of 0 to 4 pulses.
inline PulseMap pulse_map(int width = 6, int height = 5, unsigned seed = 3) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<float> number(-100.0F, 100.0F);
    PulseMap map;
    map.mode = StripeMode::spatial;
    map.width = width;
    map.height = height;
    map.camera_id = 1;
    map.frames = 200;
    map.frames_dropped = 2;
    map.saturated_samples = 17;
    map.cell_begin.push_back(0);
    for (int i = 0; i < width * height; ++i) {
        for (auto k = rng() % 5; k > 0; --k) {
            Pulse pulse{number(rng), number(rng), static_cast<TimeNs>(rng()), 0.1, 0.2};
            pulse.amplitude = number(rng);
            pulse.width = number(rng);
            pulse.background = number(rng);
            pulse.sigma = number(rng);
            pulse.chi_square = number(rng);
            pulse.flags = static_cast<std::uint16_t>(rng() % 128);
            pulse.laser_id = 2;
            pulse.exposure_index = 1;
            map.pulses.push_back(pulse);
        }
        map.cell_begin.push_back(static_cast<std::uint32_t>(map.pulses.size()));
    }
    return map;
}

inline PathTable path_table() {
    PathTable table;
    table.camera_id = 1;
    table.laser_id = 2;
    table.image_width = 64;
    table.image_height = 48;
    table.nodes_x = 2;
    table.nodes_y = 3;
    table.model_hash = "abc123";
    table.du_ds = {1, 2, 3, 4, 5, 6};
    table.dv_ds = {7, 8, 9, 10, 11, 12};
    table.d2u_ds2 = {-1, -2, -3, -4, -5, -6};
    table.d2v_ds2 = {0.5F, 1.5F, 2.5F, 3.5F, 4.5F, 5.5F};
    table.width_s = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F};
    table.valid = {1, 0, 1, 1, 0, 1};
    return table;
}

inline Health health() {
    return {77, DeviceState::running, true, true, 1.5, 12, 1, "one frame lost"};
}

inline End end() { return {false, "interlock opened", 120, 3, 2.25}; }

inline Request request() {
    Request request;
    request.id = 5;
    request.verb = RequestVerb::start;
    request.client = "test";
    request.role = Role::control;
    request.name = "ExposureTime";
    request.value = 12.5;
    request.plan = plan();
    request.credit_bytes = 1ULL << 40;
    request.run = 3;
    request.channels = kSelectData | kSelectHealth;
    return request;
}

inline Request paths_request() {
    Request request;
    request.id = 6;
    request.verb = RequestVerb::set_paths;
    request.paths = path_table();
    return request;
}

inline Response response() {
    Response response;
    response.id = 5;
    response.ok = false;
    response.error = "no";
    response.role = Role::control;
    response.run = 9;
    response.snapshot = snapshot();
    response.features = features();
    return response;
}

inline std::vector<Message> all() {
    PulseMap map = pulse_map();
    return {snapshot(),     frame(),  frame(9, 4, 12), axis_log(), PulseBand{map, 0, map.height},
            path_table(),   health(), end(),           request(),  response(),
            paths_request()};
}

}  // namespace stria::samples

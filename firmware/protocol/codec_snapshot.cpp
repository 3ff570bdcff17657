#include "firmware/protocol/validate.h"
#include "firmware/protocol/wire.h"

namespace stria {
namespace wire_format {
namespace {

flatbuffers::Offset<wire::Device> put(Builder& b, const DeviceDescription& d) {
    const auto model = b.CreateString(d.model_name);
    const auto serial = b.CreateString(d.serial);
    const auto version = b.CreateString(d.firmware_version);
    const auto kind = b.CreateString(d.kind);
    const auto camera = b.CreateString(d.camera_name);
    const auto axis = b.CreateString(d.axis_name);
    return wire::CreateDevice(b, model, serial, version, kind, d.simulated, camera, d.width,
                              d.height, d.bits, d.noise.gain_e_per_dn, d.noise.read_noise_e,
                              d.noise.black_dn, d.row_time_ns, d.min_frame_period_ns,
                              d.min_exposure_ns, d.max_exposure_ns, d.timestamp_sigma_ns, axis,
                              d.axis_min, d.axis_max, d.axis_max_speed, d.axis_sigma, d.lasers);
}

DeviceDescription get(const wire::Device* w) {
    DeviceDescription d;
    if (w == nullptr) return d;  // validate() refuses its size of 0 x 0
    d.model_name = text_of(w->model_name());
    d.serial = text_of(w->serial());
    d.firmware_version = text_of(w->firmware_version());
    d.kind = text_of(w->kind());
    d.simulated = w->simulated();
    d.camera_name = text_of(w->camera_name());
    d.width = w->width();
    d.height = w->height();
    d.bits = w->bits();
    d.noise = {w->gain_e_per_dn(), w->read_noise_e(), w->black_dn()};
    d.row_time_ns = w->row_time_ns();
    d.min_frame_period_ns = w->min_frame_period_ns();
    d.min_exposure_ns = w->min_exposure_ns();
    d.max_exposure_ns = w->max_exposure_ns();
    d.timestamp_sigma_ns = w->timestamp_sigma_ns();
    d.axis_name = text_of(w->axis_name());
    d.axis_min = w->axis_min();
    d.axis_max = w->axis_max();
    d.axis_max_speed = w->axis_max_speed();
    d.axis_sigma = w->axis_sigma();
    d.lasers = w->lasers();
    return d;
}

}  // namespace

flatbuffers::Offset<wire::FeatureValue> put(Builder& b, const FeatureValue& value) {
    const auto* integer = std::get_if<std::int64_t>(&value);
    const auto* number = std::get_if<double>(&value);
    const auto* text = std::get_if<std::string>(&value);
    const auto* boolean = std::get_if<bool>(&value);
    const std::int64_t whole = integer ? *integer : (boolean && *boolean ? 1 : 0);
    const auto string = text ? b.CreateString(*text) : flatbuffers::Offset<flatbuffers::String>();
    return wire::CreateFeatureValue(b, static_cast<std::uint8_t>(value.index()), whole,
                                    number ? *number : 0.0, string);
}

FeatureValue get(const wire::FeatureValue* value) {
    if (value == nullptr) return std::int64_t{0};
    switch (value->type()) {
        case 1:
            return value->number();
        case 2:
            return text_of(value->text());
        case 3:
            return value->integer() != 0;
        default:
            return value->integer();
    }
}

flatbuffers::Offset<wire::Feature> put(Builder& b, const Feature& f) {
    const auto name = b.CreateString(f.name);
    const auto unit = b.CreateString(f.unit);
    const auto description = b.CreateString(f.description);
    const auto value = put(b, f.value);
    const FeatureRange range = f.range.value_or(FeatureRange{});
    const auto reason = b.CreateString(range.reason);
    return wire::CreateFeature(b, name, unit, description, value,
                               static_cast<std::uint8_t>(f.access), f.range.has_value(), range.min,
                               range.max, reason);
}

Feature get(const wire::Feature& w) {
    Feature f;
    f.name = text_of(w.name());
    f.unit = text_of(w.unit());
    f.description = text_of(w.description());
    f.value = get(w.value());
    f.access = static_cast<Access>(w.access());
    if (w.has_range()) f.range = {w.min(), w.max(), text_of(w.limit_reason())};
    return f;
}

flatbuffers::Offset<wire::Plan> put(Builder& b, const ScanPlan& p) {
    const auto exposures = b.CreateVector(p.exposures_us);
    const auto lasers = b.CreateVector(p.lasers);
    return wire::CreatePlan(b, static_cast<std::uint8_t>(p.mode), p.from, p.to, p.step, exposures,
                            p.laser_power, lasers, p.off_frames, p.off_exposure_us,
                            p.both_directions, static_cast<std::uint8_t>(p.record),
                            p.max_emission_s);
}

std::optional<ScanPlan> get(const wire::Plan* w) {
    if (w == nullptr) return std::nullopt;
    ScanPlan p;
    p.mode = static_cast<StripeMode>(w->mode());
    p.from = w->from();
    p.to = w->to();
    p.step = w->step();
    p.exposures_us = vector_of(w->exposures_us());
    p.laser_power = w->laser_power();
    p.lasers = vector_of(w->lasers());
    p.off_frames = w->off_frames();
    p.off_exposure_us = w->off_exposure_us();
    p.both_directions = w->both_directions();
    p.record = static_cast<RecordWhat>(w->record());
    p.max_emission_s = w->max_emission_s();
    return p;
}

flatbuffers::Offset<wire::Snapshot> put(Builder& b, const Snapshot& s) {
    std::vector<flatbuffers::Offset<wire::Feature>> list;
    for (const Feature& feature : s.features) list.push_back(put(b, feature));
    const auto features = b.CreateVector(list);
    const auto device = put(b, s.device);
    const auto plan = put(b, s.plan);
    const auto model = b.CreateString(s.model_text);
    return wire::CreateSnapshot(b, s.protocol_version, s.clock_ns, device, features, plan, model);
}

Snapshot get(const wire::Snapshot& w) {
    Snapshot s;
    s.protocol_version = w.protocol_version();
    s.clock_ns = w.clock_ns();
    s.device = get(w.device());
    s.features = get_features(w.features());
    if (auto plan = get(w.plan())) s.plan = *plan;
    s.model_text = text_of(w.model_text());
    return s;
}

Result<Message> decode_snapshot(std::span<const std::uint8_t> payload) {
    const auto* root = verified_root<wire::Snapshot>(payload);
    if (root == nullptr) return malformed("snapshot");
    Snapshot snapshot = get(*root);
    const std::string complaint = validate(snapshot);
    return checked("snapshot", std::move(snapshot), complaint);
}

}  // namespace wire_format

Bytes encode(const Snapshot& snapshot) {
    wire_format::Builder builder;
    builder.Finish(wire_format::put(builder, snapshot));
    return wire_format::finished(builder);
}

}  // namespace stria

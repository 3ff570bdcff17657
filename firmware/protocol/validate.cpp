#include "firmware/protocol/validate.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace stria {
namespace {

std::string bad(const std::string& field, const std::string& found, const std::string& expected) {
    return field + ": expected " + expected + ", found " + found;
}
std::string bad(const std::string& field, double found, const std::string& expected) {
    return bad(field, std::to_string(found), expected);
}
std::string bad(const std::string& field, int found, const std::string& expected) {
    return bad(field, std::to_string(found), expected);
}

bool in(int value, int low, int high) { return value >= low && value <= high; }

template <typename T>
bool all_finite(const std::vector<T>& values) {
    return std::all_of(values.begin(), values.end(), [](T x) { return std::isfinite(x); });
}

bool is_short(const std::string& text) { return text.size() <= kMaxText; }

bool is_finite(const FeatureValue& value) {
    const double* number = std::get_if<double>(&value);
    return number == nullptr || std::isfinite(*number);
}

std::string check_image_size(int width, int height, int bits) {
    if (!in(width, 1, kMaxFrameSide)) return bad("width", width, "1 to 16384");
    if (!in(height, 1, kMaxFrameSide)) return bad("height", height, "1 to 16384");
    if (!in(bits, 8, 16)) return bad("bits", bits, "8 to 16");
    return "";
}

std::string check_features(const std::vector<Feature>& features) {
    if (features.size() > kMaxFeatures)
        return bad("features", std::to_string(features.size()), "at most 1000");
    for (const Feature& feature : features)
        if (std::string why = validate(feature); !why.empty()) return why;
    return "";
}

}  // namespace

std::string validate(const Feature& feature) {
    if (feature.name.empty() || feature.name.size() > 64)
        return bad("feature name", "\"" + feature.name.substr(0, 64) + "\"", "1 to 64 bytes");
    const std::string field = "feature " + feature.name;
    if (!is_short(feature.unit) || !is_short(feature.description))
        return bad(field, "a longer text", "unit and description of at most 4096 bytes");
    if (const auto* text = std::get_if<std::string>(&feature.value); text && !is_short(*text))
        return bad(field, "a longer text", "at most 4096 bytes");
    if (!is_finite(feature.value)) return bad(field, "not a number", "a finite value");
    if (!in(static_cast<int>(feature.access), 0, 1))
        return bad(field + " access", static_cast<int>(feature.access), "0 or 1");
    if (!feature.range) return "";
    if (!std::isfinite(feature.range->min) || !std::isfinite(feature.range->max) ||
        feature.range->min > feature.range->max)
        return bad(field + " min", feature.range->min, "finite and at most max");
    return is_short(feature.range->reason) ? "" : bad(field + " reason", "more", "<= 4096 bytes");
}

std::string validate(const DeviceDescription& d) {
    if (std::string why = check_image_size(d.width, d.height, d.bits); !why.empty())
        return "device: " + why;
    for (const std::string* text :
         {&d.model_name, &d.serial, &d.firmware_version, &d.camera_name, &d.axis_name})
        if (!is_short(*text)) return "device: a text is longer than 4096 bytes";
    if (d.kind != "swept" && d.kind != "rail" && d.kind != "turntable")
        return bad("device kind", "\"" + d.kind.substr(0, 64) + "\"", "swept, rail or turntable");
    const std::array numbers = {
        d.noise.gain_e_per_dn, d.noise.read_noise_e, d.noise.black_dn, d.axis_min, d.axis_max,
        d.axis_max_speed,      d.axis_sigma};
    if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); }))
        return bad("device noise and axis", "a number that is not finite", "finite numbers");
    if (!(d.noise.gain_e_per_dn > 0)) return bad("gain_e_per_dn", d.noise.gain_e_per_dn, "> 0");
    if (d.axis_min > d.axis_max) return bad("axis_min", d.axis_min, "at most axis_max");
    for (TimeNs time : {d.row_time_ns, d.min_frame_period_ns, d.min_exposure_ns, d.max_exposure_ns,
                        d.timestamp_sigma_ns})
        if (time < 0) return bad("device times", std::to_string(time) + " ns", "0 or more");
    if (!in(d.lasers, 0, 255)) return bad("lasers", d.lasers, "0 to 255");
    return "";
}

std::string validate(const Snapshot& snapshot) {
    if (snapshot.protocol_version != kProtocolVersion)
        return bad("protocol_version", snapshot.protocol_version, "1");
    if (std::string why = validate(snapshot.device); !why.empty()) return why;
    if (std::string why = check_features(snapshot.features); !why.empty()) return why;
    if (snapshot.model_text.size() > kMaxModelText)
        return bad("model_text", std::to_string(snapshot.model_text.size()), "at most 4194304");
    const std::string why = validate(snapshot.plan);
    return why.empty() ? "" : "plan: " + why;
}

std::string validate(const Frame& frame) {
    if (std::string why = check_image_size(frame.width, frame.height, frame.bits); !why.empty())
        return why;
    const std::size_t size = static_cast<std::size_t>(frame.width) *
                             static_cast<std::size_t>(frame.height) *
                             static_cast<std::size_t>(frame.bytes_per_sample());
    if (frame.bytes.size() != size)
        return bad("pixels", std::to_string(frame.bytes.size()) + " bytes", std::to_string(size));
    if (!(frame.laser_power >= 0 && frame.laser_power <= 1))
        return bad("laser_power", static_cast<double>(frame.laser_power), "0 to 1");
    if (frame.exposure_ns < 0 || frame.exposure_ns > 1000 * kNsPerSecond)
        return bad("exposure_ns", std::to_string(frame.exposure_ns), "0 to 1000 s");
    if (frame.row_time_ns < 0 || frame.row_time_ns > kNsPerSecond)
        return bad("row_time_ns", std::to_string(frame.row_time_ns), "0 to 1 s");
    return "";
}

std::string validate(const AxisLog& log) {
    if (!is_valid(log)) return "axis log: expected ascending times and finite positions";
    if (!(log.sigma_s >= 0) || !std::isfinite(log.sigma_s))
        return bad("axis log sigma_s", log.sigma_s, "0 or more");
    return "";
}

std::string validate(const PulseBand& band) {
    if (!in(band.map.width, 1, kMaxMapWidth)) return bad("width", band.map.width, "1 to 1000000");
    if (!in(band.full_height, 1, kMaxFrameSide))
        return bad("full_height", band.full_height, "1 to 16384");
    const std::int64_t cells = std::int64_t{band.map.width} * band.full_height;
    if (cells > kMaxMapCells) return bad("cells", std::to_string(cells), "at most 67108864");
    if (!in(band.first_row, 0, band.full_height - 1))
        return bad("first_row", band.first_row, "0 to full_height - 1");
    if (!in(band.map.height, 1, band.full_height - band.first_row))
        return bad("rows", band.map.height, "1 to what is left of full_height");
    if (!in(static_cast<int>(band.map.mode), 0, 1))
        return bad("mode", static_cast<int>(band.map.mode), "0 or 1");
    if (!is_valid(band.map)) return "pulse map: expected ascending cells of finite pulses";
    return "";
}

std::string validate(const Health& health) {
    if (!in(static_cast<int>(health.state), 0, 3))
        return bad("state", static_cast<int>(health.state), "0 to 3");
    if (!std::isfinite(health.emission_s)) return bad("emission_s", health.emission_s, "finite");
    return is_short(health.message) ? "" : bad("message", "more", "at most 4096 bytes");
}

std::string validate(const End& end) {
    if (!std::isfinite(end.emission_s)) return bad("emission_s", end.emission_s, "finite");
    return is_short(end.reason) ? "" : bad("reason", "more", "at most 4096 bytes");
}

std::string validate(const Request& request) {
    if (!in(static_cast<int>(request.verb), 0, kLastRequestVerb))
        return bad("verb", static_cast<int>(request.verb),
                   "0 to " + std::to_string(kLastRequestVerb));
    if (!in(static_cast<int>(request.role), 0, 1))
        return bad("role", static_cast<int>(request.role), "0 or 1");
    if (!is_short(request.client) || !is_short(request.name))
        return "request: a text is longer than 4096 bytes";
    if (const auto* text = std::get_if<std::string>(&request.value); text && !is_short(*text))
        return "request: a text is longer than 4096 bytes";
    if (!is_finite(request.value)) return bad("value", "not a number", "a finite value");
    if (request.channels > (kSelectData | kSelectHealth))
        return bad("channels", static_cast<int>(request.channels), "0 to 3");
    if (request.paths)
        if (std::string why = validate(*request.paths); !why.empty()) return "paths: " + why;
    if (!request.plan) return request.verb == RequestVerb::start ? "start: expected a plan" : "";
    const std::string why = validate(*request.plan);
    return why.empty() ? "" : "plan: " + why;
}

std::string validate(const Response& response) {
    if (!is_short(response.error)) return bad("error", "more", "at most 4096 bytes");
    if (!in(static_cast<int>(response.role), 0, 1))
        return bad("role", static_cast<int>(response.role), "0 or 1");
    if (response.snapshot)
        if (std::string why = validate(*response.snapshot); !why.empty()) return why;
    return check_features(response.features);
}

}  // namespace stria

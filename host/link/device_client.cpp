#include "host/link/device_client.h"

#include <charconv>

#include "firmware/transport/socket.h"
#include "host/core/errors.h"
#include "host/link/link_client.h"

namespace stria {
namespace {

template <typename T>
T parsed(const Feature& feature, const std::string& text, const char* expected) {
    T value{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && stop == end && !text.empty()) return value;
    throw Error(feature.name + ": expected " + expected + ", found \"" + text + "\"");
}

}  // namespace

std::unique_ptr<DeviceClient> connect_device(const std::string& uri,
                                             const ConnectOptions& options) {
    if (uri.starts_with("replay:")) return make_replay_client(uri.substr(7));
    if (!uri.starts_with("unix:") && !uri.starts_with("tcp:"))
        throw Error("\"" + uri +
                    "\" is no device: expected sim:SCENE.toml, unix:PATH, tcp:HOST:PORT or "
                    "replay:FILE");
    const auto address = parse_address(uri);
    if (!address) throw Error(address.failure().message);
    auto stream = connect_socket(*address, options.timeout);
    if (!stream) throw DeviceError(stream.failure().message);
    return make_link_client(std::move(*stream), options);
}

FeatureValue parse_feature_value(const Feature& feature, const std::string& text) {
    if (std::holds_alternative<std::int64_t>(feature.value))
        return parsed<std::int64_t>(feature, text, "a whole number");
    if (std::holds_alternative<double>(feature.value))
        return parsed<double>(feature, text, "a number");
    if (std::holds_alternative<std::string>(feature.value)) return text;
    if (text == "true" || text == "1") return true;
    if (text == "false" || text == "0") return false;
    throw Error(feature.name + ": expected true or false, found \"" + text + "\"");
}

std::string to_string(const FeatureValue& value) {
    if (const auto* whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
    if (const auto* boolean = std::get_if<bool>(&value)) return *boolean ? "true" : "false";
    if (const auto* text = std::get_if<std::string>(&value)) return *text;
    char buffer[32];
    const auto [end, error] =
        std::to_chars(buffer, buffer + sizeof buffer, std::get<double>(value));
    return error == std::errc() ? std::string(buffer, end) : std::string();
}

}  // namespace stria

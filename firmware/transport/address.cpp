#include "firmware/transport/address.h"

#include <charconv>

namespace stria {
namespace {

constexpr std::size_t kMaxSocketPath = 107;  // sun_path holds 108 with its final zero

Failure bad(const std::string& text, const std::string& why) {
    return {"\"" + text + "\": " + why +
            "; right are unix:/run/stria/scanner.sock and "
            "tcp:127.0.0.1:7700"};
}

Result<Address> parse_tcp(const std::string& text) {
    const std::string rest = text.substr(4);
    const std::size_t colon = rest.rfind(':');
    if (colon == std::string::npos) return bad(text, "expected HOST:PORT after tcp:");
    Address address{.kind = Address::Kind::tcp, .path = {}, .host = rest.substr(0, colon)};
    if (address.host == "localhost") address.host = "127.0.0.1";
    if (address.host == "[::1]") address.host = "::1";
    if (address.host != "127.0.0.1" && address.host != "::1")
        return bad(text,
                   "only this computer (127.0.0.1, ::1, localhost) can be reached by tcp: "
                   "connections over a network need keys, which this version does not have");
    const char* begin = rest.data() + colon + 1;
    const char* end = rest.data() + rest.size();
    const auto [stop, error] = std::from_chars(begin, end, address.port);
    if (error != std::errc() || stop != end || begin == end)
        return bad(text, "expected a port from 0 to 65535");
    return address;
}

}  // namespace

Result<Address> parse_address(const std::string& text) {
    if (text.starts_with("tcp:")) return parse_tcp(text);
    if (!text.starts_with("unix:")) return bad(text, "expected unix:PATH or tcp:HOST:PORT");
    const std::string path = text.substr(5);
    if (path.empty()) return bad(text, "expected a path after unix:");
    if (path.size() > kMaxSocketPath)
        return bad(
            text, "a socket's path has at most 107 bytes, this one " + std::to_string(path.size()));
    return Address{.kind = Address::Kind::unix_socket, .path = path, .host = {}};
}

std::string to_string(const Address& address) {
    if (address.kind == Address::Kind::unix_socket) return "unix:" + address.path;
    return "tcp:" + address.host + ":" + std::to_string(address.port);
}

}  // namespace stria

#pragma once
#include <cstdint>
#include <string>

#include "firmware/core/result.h"

namespace stria {

/// Where a scanner listens: "unix:PATH" or "tcp:HOST:PORT".
struct Address {
    enum class Kind : std::uint8_t { unix_socket, tcp };
    Kind kind = Kind::unix_socket;
    std::string path;        ///< Unix socket
    std::string host;        ///< TCP: "127.0.0.1" or "::1"
    std::uint16_t port = 0;  ///< TCP; 0: any free one, for listening only
};

/// Reads an address; the message says which part is wrong and shows a right one. TCP hosts other
/// than 127.0.0.1, ::1 and localhost are refused: over a network a connection must be encrypted and
/// know its peer, and this version has no keys yet.
Result<Address> parse_address(const std::string& text);

std::string to_string(const Address& address);

}  // namespace stria

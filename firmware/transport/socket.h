#pragma once
#include <memory>
#include <string>

#include "firmware/protocol/byte_stream.h"
#include "firmware/transport/address.h"

namespace stria {

/// Connects within `timeout`; the message says whether nothing listens or nothing answers.
Result<std::unique_ptr<ByteStream>> connect_socket(const Address& address, Milliseconds timeout);

/// Accepts connections. close() may come from any thread and wakes accept().
class Listener {
  public:
    virtual ~Listener() = default;
    /// The next client; null if none came in time, or the listener was closed. On a Unix socket
    /// only processes of the same user, or root, are let in; others are turned away here.
    virtual Result<std::unique_ptr<ByteStream>> accept(Milliseconds timeout) = 0;
    virtual void close() = 0;
    /// Where it really listens (the port chosen for port 0).
    virtual Address address() const = 0;
};

/// Listens. A socket file that a dead server left is replaced; one that answers, and any other
/// file, is refused. Unix sockets are readable and writable by their owner alone and removed at the
/// end.
Result<std::unique_ptr<Listener>> listen_socket(const Address& address);

}  // namespace stria

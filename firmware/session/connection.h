#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "firmware/protocol/messages.h"
#include "firmware/session/outbox.h"

namespace stria {

class Connection;

/// What a connection asks of its server. Calls come from the connection's reading thread.
class ConnectionOwner {
  public:
    virtual ~ConnectionOwner() = default;
    /// The answer; its id is filled in by the connection.
    virtual Response answer(Connection& connection, const Request& request) = 0;
    /// The client has closed, broken off or fallen silent; `why` says which.
    virtual void lost(Connection& connection, const std::string& why) = 0;
};

struct ConnectionOptions {
    Milliseconds silence{5000};  ///< without any message the client counts as lost
    Milliseconds write_timeout{10'000};
    std::size_t max_data_bytes = std::size_t{64} << 20;  ///< waiting to be sent
};

/// One client of a session: a thread that reads requests, one that writes from the outbox.
class Connection {
  public:
    Connection(std::unique_ptr<ByteStream> stream, ConnectionOwner& owner,
               const ConnectionOptions& options);
    ~Connection();  ///< ends both threads
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    void start();
    /// Lets the threads end; returns at once.
    void close();
    bool is_finished() const { return finished_; }
    Outbox& outbox() { return outbox_; }
    void send_health(const Health& health);

    // State that the owner keeps with the client; the owner's lock guards it.
    std::string client = "client";
    bool said_hello = false;
    Role role = Role::watch;
    std::uint8_t channels = kSelectHealth;

  private:
    void read_requests();
    std::string read_until_lost();
    bool take(const RawMessage& raw, std::string& why);
    void write_messages();

    std::unique_ptr<ByteStream> stream_;
    ConnectionOwner& owner_;
    const ConnectionOptions options_;
    Outbox outbox_;
    std::uint32_t control_sequence_ = 0;  // reading thread
    std::atomic<std::uint32_t> health_sequence_ = 0;
    std::atomic<bool> closing_ = false, finished_ = false;
    std::thread reader_, writer_;
};

}  // namespace stria

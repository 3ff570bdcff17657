#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "firmware/protocol/byte_stream.h"
#include "firmware/protocol/messages.h"

namespace stria {

/// The client's side of the protocol over one stream. A thread of its own reads, and sends a
/// heartbeat where nothing else was sent; the caller's thread asks and takes data. Memory for data
/// is bounded by the credit given. Failures are DeviceError.
class ConnectionToDevice {
  public:
    ConnectionToDevice(std::unique_ptr<ByteStream> stream, std::chrono::milliseconds timeout);
    ~ConnectionToDevice();
    ConnectionToDevice(const ConnectionToDevice&) = delete;
    ConnectionToDevice& operator=(const ConnectionToDevice&) = delete;

    /// The device's answer, which may be a refusal; throws if there is none within the timeout.
    Response ask(Request request);
    /// ask(), but a refusal throws the device's reason.
    Response demand(Request request);
    /// Sent without waiting for an answer.
    void tell(Request request);
    /// The next data message; empty after `wait`. Throws when the link is broken and all that came
    /// has been taken.
    std::optional<RawMessage> next_data(std::chrono::milliseconds wait);
    void drop_data();
    std::optional<Health> last_health() const;
    std::string name() const { return stream_->name(); }

  private:
    void read_messages();
    std::string read_until_broken();
    void take(RawMessage raw);
    void send(const Request& request);
    bool send_heartbeat();

    std::unique_ptr<ByteStream> stream_;
    const std::chrono::milliseconds timeout_;
    mutable std::mutex mutex_;  // guards what follows, up to the writing lock
    std::condition_variable changed_;
    std::map<std::uint32_t, Response> responses_;
    std::deque<RawMessage> data_;
    std::optional<Health> health_;
    std::string broken_;  // why
    std::uint32_t next_id_ = 1;
    std::mutex writing_;
    std::uint32_t sequence_ = 0;
    std::atomic<bool> closing_ = false;
    std::thread reader_;
};

}  // namespace stria

#pragma once
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>

#include "firmware/protocol/byte_stream.h"

namespace stria {

/// Shared because one data message may wait for several clients at once.
using SharedMessage = std::shared_ptr<const RawMessage>;

/// What waits to be sent to one client. Control and health always go before data, and data only
/// against credit that the client has given; so a response never waits for more than the one
/// message that is being written. Any thread may call.
class Outbox {
  public:
    enum class Put : std::uint8_t { done, full, closed };

    explicit Outbox(std::size_t max_data_bytes) : max_data_bytes_(max_data_bytes) {}

    /// False if closed, or if the client has left 1000 of them unread.
    bool put_urgent(SharedMessage message);
    /// Waits up to `patience` for room.
    Put put_data(SharedMessage message, Milliseconds patience);
    void add_credit(std::uint64_t bytes);
    /// The next message to send; null if there is none in time or the outbox is closed.
    SharedMessage next(Milliseconds timeout);
    /// Drops data that has not been sent, and the credit left.
    void clear_data();
    void close();
    bool is_closed() const;

  private:
    static std::size_t size_of(const SharedMessage& message) {
        return kHeaderBytes + message->payload.size();
    }

    const std::size_t max_data_bytes_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<SharedMessage> urgent_, data_;
    std::size_t data_bytes_ = 0;
    std::uint64_t credit_ = 0;
    bool closed_ = false;
};

}  // namespace stria

#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "firmware/core/result.h"
#include "firmware/protocol/framing.h"

namespace stria {

using Milliseconds = std::chrono::milliseconds;

/// What a read brought: bytes > 0; or nothing because time ran out; or nothing for ever, because
/// the other end closed.
struct ReadSome {
    std::size_t bytes = 0;
    bool timed_out = false;

    bool is_closed() const { return bytes == 0 && !timed_out; }
};

/// A two-way flow of bytes. One thread may read while another writes; close() may be called from
/// any thread and wakes both. No call throws.
class ByteStream {
  public:
    virtual ~ByteStream() = default;
    /// Waits until something can be read, at most `timeout`; may bring less than `out` holds.
    virtual Result<ReadSome> read_some(std::span<std::uint8_t> out, Milliseconds timeout) = 0;
    /// All of `bytes` or a failure; waits at most `timeout` without progress.
    virtual Status write_all(std::span<const std::uint8_t> bytes, Milliseconds timeout) = 0;
    virtual void close() = 0;
    /// For messages: "unix:/run/stria/a.sock".
    virtual std::string name() const = 0;
};

/// One message, header and payload checked. Empty if the stream closed between two messages, or if
/// nothing at all came within `idle_timeout` (then `timed_out` is set). Once its first byte has
/// arrived, a message must keep coming: a longer pause is a failure.
struct ReadMessage {
    std::optional<RawMessage> message;
    bool timed_out = false;
};
Result<ReadMessage> read_message(ByteStream& stream, Milliseconds idle_timeout,
                                 Milliseconds longest_pause = Milliseconds(10'000));

/// Header and payload.
Status write_message(ByteStream& stream, const RawMessage& message, Milliseconds timeout);

}  // namespace stria

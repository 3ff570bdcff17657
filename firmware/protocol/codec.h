#pragma once
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/core/result.h"
#include "firmware/protocol/framing.h"
#include "firmware/protocol/messages.h"

/// Plain structs to payloads and back; FlatBuffers stays behind it.
namespace stria {

/// The payload of a message. Precondition: validate(message) is empty.
Bytes encode(const Snapshot& snapshot);
Bytes encode(const Frame& frame);  ///< pixels packed where that saves an eighth or more
Bytes encode(const AxisLog& log);
Bytes encode(const PulseBand& band);  ///< columns, their bytes sorted by significance, packed
Bytes encode(const PathTable& table);
Bytes encode(const Health& health);
Bytes encode(const End& end);
Bytes encode(const Request& request);
Bytes encode(const Response& response);

MessageType type_of(const Message& message);

/// The id of a request that decode() refuses for what it holds, so that it can be answered; empty
/// if not even that can be read.
std::optional<std::uint32_t> request_id(std::span<const std::uint8_t> payload);

/// The struct in a payload: FlatBuffers verified, then decoded, then validate()d. Bytes from
/// outside: never throws on them, and takes memory in proportion to what width x height say, at
/// most kMaxPayloadBytes of pixels or packed pulses.
Result<Message> decode(MessageType type, std::span<const std::uint8_t> payload);

}  // namespace stria

#include "firmware/protocol/codec.h"

#include "firmware/protocol/wire.h"

namespace stria {
namespace wire_format {

static_assert(__STDCPP_DEFAULT_NEW_ALIGNMENT__ >= 16, "payloads must be aligned to 16 bytes");

Bytes finished(Builder& builder) {
    return Bytes(builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize());
}

namespace {

Result<Message> decode_aligned(MessageType type, std::span<const std::uint8_t> payload) {
    switch (type) {
        case MessageType::snapshot:
            return decode_snapshot(payload);
        case MessageType::frame:
            return decode_frame(payload);
        case MessageType::axis_log:
            return decode_axis_log(payload);
        case MessageType::pulse_band:
            return decode_pulse_band(payload);
        case MessageType::path_table:
            return decode_path_table(payload);
        case MessageType::health:
            return decode_health(payload);
        case MessageType::end:
            return decode_end(payload);
        case MessageType::request:
            return decode_request(payload);
        case MessageType::response:
            return decode_response(payload);
    }
    return Failure{"message type " + std::to_string(static_cast<int>(type)) + " is not known"};
}

}  // namespace
}  // namespace wire_format

MessageType type_of(const Message& message) {
    constexpr MessageType kTypes[] = {
        MessageType::snapshot,   MessageType::frame,      MessageType::axis_log,
        MessageType::pulse_band, MessageType::path_table, MessageType::health,
        MessageType::end,        MessageType::request,    MessageType::response};
    return kTypes[message.index()];
}

Result<Message> decode(MessageType type, std::span<const std::uint8_t> payload) {
    if (payload.size() > kMaxPayloadBytes) return Failure{"payload: expected at most 64 MiB"};
    if (reinterpret_cast<std::uintptr_t>(payload.data()) % 16 == 0)
        return wire_format::decode_aligned(type, payload);
    const Bytes aligned(payload.begin(), payload.end());
    return wire_format::decode_aligned(type, aligned);
}

}  // namespace stria

#include "firmware/protocol/byte_stream.h"

#include <algorithm>
#include <array>

namespace stria {
namespace {

constexpr std::size_t kGrowth = std::size_t{1} << 20;  // memory follows what has really arrived

Failure broke_off(const ByteStream& stream, const char* why) {
    return {stream.name() + ": " + why + " in the middle of a message"};
}

/// Fills `out` whole.
Status read_rest(ByteStream& stream, std::span<std::uint8_t> out, Milliseconds pause) {
    while (!out.empty()) {
        const Result<ReadSome> read = stream.read_some(out, pause);
        if (!read) return read.failure();
        if (read->timed_out) return broke_off(stream, "nothing more came");
        if (read->is_closed()) return broke_off(stream, "the other end closed");
        out = out.subspan(read->bytes);
    }
    return {};
}

Status read_payload(ByteStream& stream, Bytes& payload, std::size_t length, Milliseconds pause) {
    while (payload.size() < length) {
        const std::size_t have = payload.size();
        const std::size_t step = std::min(length - have, std::max(kGrowth, have));
        payload.resize(have + step);
        const Status done = read_rest(stream, std::span(payload).subspan(have), pause);
        if (!done) return done.failure();
    }
    return {};
}

}  // namespace

Result<ReadMessage> read_message(ByteStream& stream, Milliseconds idle_timeout,
                                 Milliseconds longest_pause) {
    std::array<std::uint8_t, kHeaderBytes> bytes{};
    const Result<ReadSome> first = stream.read_some(bytes, idle_timeout);
    if (!first) return first.failure();
    if (first->bytes == 0) return ReadMessage{.message = {}, .timed_out = first->timed_out};
    const Status rest = read_rest(stream, std::span(bytes).subspan(first->bytes), longest_pause);
    if (!rest) return rest.failure();
    const Result<MessageHeader> header = decode_header(bytes);
    if (!header) return Failure{stream.name() + ": " + header.failure().message};

    ReadMessage result;
    result.message.emplace();
    result.message->header = *header;
    const Status payload =
        read_payload(stream, result.message->payload, header->length, longest_pause);
    if (!payload) return payload.failure();
    const Status whole = check_payload(*header, result.message->payload);
    if (!whole) return Failure{stream.name() + ": " + whole.failure().message};
    return result;
}

Status write_message(ByteStream& stream, const RawMessage& message, Milliseconds timeout) {
    const auto header = encode_header(message.header);
    const Status done = stream.write_all(header, timeout);
    if (!done) return done.failure();
    return stream.write_all(message.payload, timeout);
}

}  // namespace stria

#include "firmware/session/run_stream.h"

#include "firmware/protocol/codec.h"
#include "firmware/protocol/pulse_bands.h"

namespace stria {

Status RunStream::spool_to(const std::string& path) {
    auto writer = RecordingWriter::create_raw(path);
    if (!writer) return writer.failure();
    spool_ = std::move(*writer);
    return {};
}

Result<SharedMessage> RunStream::framed(MessageType type, Bytes payload) {
    if (payload.size() > kMaxPayloadBytes)
        return Failure{"a message of " + std::to_string(payload.size()) +
                       " bytes: expected at most 67108864"};
    SharedMessage message = std::make_shared<const RawMessage>(
        make_raw(WireChannel::data, type, std::move(payload), run_, sequence_++));
    if (spool_)
        if (Status done = spool_->write_raw(*message); !done) return done.failure();
    return message;
}

Status RunStream::put(MessageType type, Bytes payload) {
    const auto message = framed(type, std::move(payload));
    return message ? send_(*message) : message.failure();
}

Status RunStream::begin(const Snapshot& snapshot) {
    return put(MessageType::snapshot, encode(snapshot));
}

Status RunStream::end(const End& end) {
    const auto message = framed(MessageType::end, encode(end));
    if (!message) return message.failure();
    if (spool_)  // before the client can acknowledge
        if (Status done = spool_->close(); !done) return done;
    return send_(*message);
}

Status RunStream::take_path_table(const PathTable& table) {
    return put(MessageType::path_table, encode(table));
}

Status RunStream::take_frame(const Frame& frame) { return put(MessageType::frame, encode(frame)); }

Status RunStream::take_axis_log(const AxisLog& log) {
    return put(MessageType::axis_log, encode(log));
}

Status RunStream::take_pulse_map(const PulseMap& map) {
    for (const PulseBand& band : split_into_bands(map))
        if (Status done = put(MessageType::pulse_band, encode(band)); !done) return done;
    return {};
}

}  // namespace stria

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "firmware/protocol/codec.h"
#include "firmware/protocol/pulse_bands.h"
#include "firmware/protocol/recording.h"

namespace stria {
namespace {

std::string part_of(const std::string& path) { return path + ".part"; }

Failure file_failure(const std::string& path, const char* what) {
    return {path + ": " + what + ": " + std::strerror(errno)};
}

}  // namespace

Result<RecordingWriter> RecordingWriter::create_raw(const std::string& path) {
    RecordingWriter writer;
    writer.path_ = path;
    writer.file_.reset(std::fopen(part_of(path).c_str(), "wb"));
    if (!writer.file_) return file_failure(part_of(path), "cannot be created");
    return writer;
}

Result<RecordingWriter> RecordingWriter::create(const std::string& path, const Snapshot& snapshot,
                                                std::uint32_t session) {
    Result<RecordingWriter> writer = create_raw(path);
    if (!writer) return writer;
    writer->session_ = session;
    const Status done = writer->put(MessageType::snapshot, snapshot);
    if (!done) return done.failure();
    return writer;
}

template <typename T>
Status RecordingWriter::put(MessageType type, const T& message) {
    Bytes payload = encode(message);
    if (payload.size() > kMaxPayloadBytes)
        return Failure{path_ + ": a message of " + std::to_string(payload.size()) +
                       " bytes: expected at most 67108864"};
    return write_raw(make_raw(WireChannel::data, type, std::move(payload), session_, sequence_++));
}

Status RecordingWriter::write(const Frame& frame) { return put(MessageType::frame, frame); }
Status RecordingWriter::write(const AxisLog& log) { return put(MessageType::axis_log, log); }
Status RecordingWriter::write(const PathTable& table) {
    return put(MessageType::path_table, table);
}
Status RecordingWriter::write(const Health& health) { return put(MessageType::health, health); }

Status RecordingWriter::write(const PulseMap& map) {
    for (const PulseBand& band : split_into_bands(map)) {
        const Status done = put(MessageType::pulse_band, band);
        if (!done) return done;
    }
    return {};
}

Status RecordingWriter::write_raw(const RawMessage& message) {
    if (!file_) return Failure{path_ + ": the recording is closed already"};
    const auto header = encode_header(message.header);
    const std::size_t size = message.payload.size();
    if (std::fwrite(header.data(), 1, header.size(), file_.get()) != header.size() ||
        std::fwrite(message.payload.data(), 1, size, file_.get()) != size)
        return file_failure(part_of(path_), "cannot be written");
    bytes_written_ += header.size() + size;
    return {};
}

Status RecordingWriter::finish(const End& end) {
    const Status done = put(MessageType::end, end);
    if (!done) return done;
    return close();
}

Status RecordingWriter::close() {
    if (!file_) return {};
    if (std::fflush(file_.get()) != 0 || ::fsync(::fileno(file_.get())) != 0)
        return file_failure(part_of(path_), "cannot be written");
    file_.reset();
    if (std::rename(part_of(path_).c_str(), path_.c_str()) != 0)
        return file_failure(path_, "cannot be named");
    return {};
}

}  // namespace stria

#include <sys/stat.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "firmware/protocol/codec.h"
#include "firmware/protocol/recording.h"

namespace stria {
namespace {

constexpr std::size_t kMaxNotes = 16;

std::string at_byte(std::uint64_t offset) { return "byte " + std::to_string(offset); }

}  // namespace

Result<RecordingReader> RecordingReader::open(const std::string& path) {
    RecordingReader reader;
    reader.path_ = path;
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return Failure{path + ": " + std::strerror(errno)};
    if (!S_ISREG(status.st_mode)) return Failure{path + ": expected a file"};
    reader.size_ = static_cast<std::uint64_t>(status.st_size);
    reader.file_.reset(std::fopen(path.c_str(), "rb"));
    if (!reader.file_) return Failure{path + ": " + std::strerror(errno)};

    std::array<char, 4> magic{};
    const std::size_t got = std::fread(magic.data(), 1, magic.size(), reader.file_.get());
    if (got == 0) return Failure{path + ": the file is empty: expected a stria recording"};
    if (std::memcmp(magic.data(), "STRI", got) != 0)
        return Failure{path + ": byte 0: not a stria recording: expected \"STRI\""};
    std::rewind(reader.file_.get());
    auto first = reader.next_raw();
    if (!first) return first.failure();
    if (!*first) return Failure{path + ": its snapshot is not whole: " + reader.notes_.front()};
    if ((*first)->header.type != MessageType::snapshot)
        return Failure{path + ": byte 0: expected a snapshot, found message type " +
                       std::to_string(static_cast<int>((*first)->header.type))};
    auto message = decode(MessageType::snapshot, (*first)->payload);
    if (!message)
        return Failure{path + ": " + at_byte(kHeaderBytes) + ": " + message.failure().message,
                       kHeaderBytes};
    reader.snapshot_ = std::get<Snapshot>(std::move(*message));
    reader.snapshot_message_ = std::move(**first);
    return reader;
}

void RecordingReader::note(const std::string& text) {
    if (notes_.size() < kMaxNotes)
        notes_.push_back(text);
    else
        ++further_notes_;
}

std::vector<std::string> RecordingReader::notes() const {
    std::vector<std::string> all = notes_;
    if (further_notes_ > 0) all.push_back("and " + std::to_string(further_notes_) + " more");
    return all;
}

double RecordingReader::progress() const {
    return size_ == 0 ? 1.0 : static_cast<double>(offset_) / static_cast<double>(size_);
}

Result<std::optional<RawMessage>> RecordingReader::lose_tail(std::uint64_t offset,
                                                             const std::string& why) {
    note("tail lost after byte " + std::to_string(offset) + " of " + std::to_string(size_) + ": " +
         why);
    at_end_ = true;
    return std::optional<RawMessage>();
}

Result<std::optional<RawMessage>> RecordingReader::next_raw() {
    while (!at_end_) {
        const std::uint64_t begin = offset_;
        std::array<std::uint8_t, kHeaderBytes> bytes{};
        const std::size_t got = std::fread(bytes.data(), 1, bytes.size(), file_.get());
        if (std::ferror(file_.get()) != 0)
            return Failure{path_ + ": " + at_byte(begin) + ": cannot be read", begin};
        if (got == 0) break;
        if (got < bytes.size()) return lose_tail(begin, "cut within a message's header");
        const Result<MessageHeader> header = decode_header(bytes);
        if (!header) return lose_tail(begin, header.failure().message);
        if (begin + kHeaderBytes + header->length > size_)
            return lose_tail(begin, "cut within a message");

        RawMessage message{*header, Bytes(header->length)};
        if (std::fread(message.payload.data(), 1, header->length, file_.get()) != header->length)
            return lose_tail(begin, "cut within a message");
        offset_ = begin + kHeaderBytes + header->length;
        const Status whole = check_payload(*header, message.payload);
        if (whole) return std::optional(std::move(message));
        if (begin == 0) return lose_tail(begin, whole.failure().message);
        note(at_byte(begin) + ": message passed over: " + whole.failure().message);
    }
    at_end_ = true;
    return std::optional<RawMessage>();
}

Result<std::optional<Message>> RecordingReader::next() {
    while (true) {
        const std::uint64_t begin = offset_;
        auto raw = next_raw();
        if (!raw) return raw.failure();
        if (!*raw) return std::optional<Message>();
        auto message = decode((*raw)->header.type, (*raw)->payload);
        if (message) return std::optional(std::move(*message));
        note(at_byte(begin) + ": message passed over: " + message.failure().message);
    }
}

}  // namespace stria

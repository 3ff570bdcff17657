#pragma once
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/core/result.h"
#include "firmware/protocol/framing.h"
#include "firmware/protocol/messages.h"

/// recording.stria: the data channel on disk. Framed messages one after the other, a snapshot
/// first, an end last; see framing.h. A torn tail costs only its last message.
namespace stria {

struct FileCloser {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using FileHandle = std::unique_ptr<std::FILE, FileCloser>;

/// Writes a recording under PATH.part, which opens as a recording at any moment, and gives it its
/// own name at the end; so a killed program leaves the old file and what it has of the new one.
class RecordingWriter {
  public:
    /// The file with its snapshot written. `session` numbers the run in every header.
    static Result<RecordingWriter> create(const std::string& path, const Snapshot& snapshot,
                                          std::uint32_t session = 1);
    /// An empty file for messages that are framed already, the snapshot first.
    static Result<RecordingWriter> create_raw(const std::string& path);

    Status write(const Frame& frame);
    Status write(const AxisLog& log);
    Status write(const PulseMap& map);  ///< cut into bands
    Status write(const PathTable& table);
    Status write(const Health& health);
    /// A message of the data channel as it came over the wire, byte for byte.
    Status write_raw(const RawMessage& message);
    /// The end message, fsync, rename.
    Status finish(const End& end);
    /// fsync and rename without an end message, for a run that broke off or wrote its own end.
    Status close();

    std::uint64_t bytes_written() const { return bytes_written_; }

  private:
    template <typename T>
    Status put(MessageType type, const T& message);

    std::string path_;
    FileHandle file_;
    std::uint32_t session_ = 1;
    std::uint32_t sequence_ = 0;
    std::uint64_t bytes_written_ = 0;
};

/// Reads a recording message by message; memory holds one at a time.
class RecordingReader {
  public:
    /// Fails if the file cannot be read, is no recording, or its snapshot is not whole.
    static Result<RecordingReader> open(const std::string& path);

    const Snapshot& snapshot() const { return snapshot_; }
    /// The snapshot's message as it was written.
    const RawMessage& snapshot_message() const { return snapshot_message_; }
    /// The next message after the snapshot that can be used; empty at the end of what is whole.
    /// A message whose payload is damaged is passed over and noted; a torn tail, or a damaged
    /// header (what follows it cannot be found), ends the recording and is noted. Fails if the disk
    /// does.
    Result<std::optional<Message>> next();
    /// The same as it was written; `Failure` and notes alike, but the payload is not decoded.
    Result<std::optional<RawMessage>> next_raw();
    /// What was lost and where, sentences with byte offsets; at most 16 and then a count.
    std::vector<std::string> notes() const;
    /// Share of the file that has been read, 0..1.
    double progress() const;

  private:
    void note(const std::string& text);
    Result<std::optional<RawMessage>> lose_tail(std::uint64_t offset, const std::string& why);

    std::string path_;
    FileHandle file_;
    std::uint64_t size_ = 0;
    std::uint64_t offset_ = 0;
    bool at_end_ = false;
    Snapshot snapshot_;
    RawMessage snapshot_message_;
    std::vector<std::string> notes_;
    std::size_t further_notes_ = 0;
};

}  // namespace stria

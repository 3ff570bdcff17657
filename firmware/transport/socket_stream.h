#pragma once
#include <unistd.h>

#include <string>
#include <utility>

#include "firmware/protocol/byte_stream.h"

namespace stria {

/// Owns a file descriptor.
class FileDescriptor {
  public:
    explicit FileDescriptor(int fd = -1) : fd_(fd) {}
    ~FileDescriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    FileDescriptor(FileDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
    FileDescriptor& operator=(FileDescriptor&& other) noexcept {
        std::swap(fd_, other.fd_);
        return *this;
    }
    int get() const { return fd_; }
    explicit operator bool() const { return fd_ >= 0; }

  private:
    int fd_;
};

/// Bytes over a connected stream socket.
class SocketStream : public ByteStream {
  public:
    SocketStream(FileDescriptor fd, std::string name);
    Result<ReadSome> read_some(std::span<std::uint8_t> out, Milliseconds timeout) override;
    Status write_all(std::span<const std::uint8_t> bytes, Milliseconds timeout) override;
    void close() override;
    std::string name() const override { return name_; }

  private:
    FileDescriptor fd_;  // closed by the destructor alone, so that no thread uses a reused number
    std::string name_;
};

/// True if poll() reports one of `events` within the time.
bool wait_for(int fd, short events, Milliseconds timeout);

/// NAME: WHAT: strerror(errno).
Failure system_failure(const std::string& name, const std::string& what);

}  // namespace stria

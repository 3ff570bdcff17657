#include "firmware/transport/memory_stream.h"

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <vector>

namespace stria {
namespace {

/// One direction: a ring of bytes between two threads.
class Pipe {
  public:
    explicit Pipe(std::size_t capacity) : ring_(capacity) {}

    ReadSome read(std::span<std::uint8_t> out, Milliseconds timeout) {
        std::unique_lock lock(mutex_);
        const bool ready = changed_.wait_for(lock, timeout, [&] { return size_ > 0 || closed_; });
        if (!ready) return {.bytes = 0, .timed_out = true};
        const std::size_t bytes = std::min(out.size(), size_);
        const std::size_t first = std::min(bytes, ring_.size() - begin_);
        std::memcpy(out.data(), &ring_[begin_], first);
        std::memcpy(out.data() + first, ring_.data(), bytes - first);
        begin_ = (begin_ + bytes) % ring_.size();
        size_ -= bytes;
        changed_.notify_all();
        return {.bytes = bytes, .timed_out = false};
    }

    /// How many bytes were taken; 0: closed, or full for the whole time.
    std::size_t write(std::span<const std::uint8_t> in, Milliseconds timeout) {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, timeout, [&] { return size_ < ring_.size() || closed_; });
        if (closed_) return 0;
        const std::size_t bytes = std::min(in.size(), ring_.size() - size_);
        const std::size_t end = (begin_ + size_) % ring_.size();
        const std::size_t first = std::min(bytes, ring_.size() - end);
        std::memcpy(&ring_[end], in.data(), first);
        std::memcpy(ring_.data(), in.data() + first, bytes - first);
        size_ += bytes;
        changed_.notify_all();
        return bytes;
    }

    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }

    bool is_closed() {
        const std::lock_guard lock(mutex_);
        return closed_;
    }

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::uint8_t> ring_;
    std::size_t begin_ = 0, size_ = 0;
    bool closed_ = false;
};

/// The two ends share both pipes: whichever is destroyed last frees them.
class MemoryStream : public ByteStream {
  public:
    MemoryStream(std::string name, std::shared_ptr<Pipe> in, std::shared_ptr<Pipe> out)
        : name_(std::move(name)), in_(std::move(in)), out_(std::move(out)) {}
    ~MemoryStream() override {
        in_->close();
        out_->close();
    }

    Result<ReadSome> read_some(std::span<std::uint8_t> out, Milliseconds timeout) override {
        return in_->read(out, timeout);
    }
    Status write_all(std::span<const std::uint8_t> bytes, Milliseconds timeout) override {
        while (!bytes.empty()) {
            const std::size_t written = out_->write(bytes, timeout);
            if (written == 0)
                return Failure{name_ + (out_->is_closed() ? ": the other end closed"
                                                          : ": nothing could be written in time")};
            bytes = bytes.subspan(written);
        }
        return {};
    }
    void close() override {
        in_->close();
        out_->close();
    }
    std::string name() const override { return name_; }

  private:
    std::string name_;
    std::shared_ptr<Pipe> in_, out_;
};

}  // namespace

StreamPair make_memory_streams(const std::string& name, std::size_t capacity) {
    const auto there = std::make_shared<Pipe>(capacity);
    const auto back = std::make_shared<Pipe>(capacity);
    return {std::make_unique<MemoryStream>(name, back, there),
            std::make_unique<MemoryStream>(name, there, back)};
}

}  // namespace stria

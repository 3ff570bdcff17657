#include "firmware/transport/socket_stream.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>

namespace stria {

Failure system_failure(const std::string& name, const std::string& what) {
    return {name + ": " + what + ": " + std::strerror(errno)};
}

bool wait_for(int fd, short events, Milliseconds timeout) {
    using SteadyClock = std::chrono::steady_clock;
    const auto end = SteadyClock::now() + timeout;
    while (true) {
        const auto left = std::chrono::ceil<Milliseconds>(end - SteadyClock::now()).count();
        pollfd poll_fd{fd, events, 0};
        const int wait = static_cast<int>(std::clamp<long>(left, 0, INT_MAX));
        const int ready = ::poll(&poll_fd, 1, wait);
        if (ready > 0) return true;
        if (ready == 0 || errno != EINTR) return false;
    }
}

SocketStream::SocketStream(FileDescriptor fd, std::string name)
    : fd_(std::move(fd)), name_(std::move(name)) {
    const int flags = ::fcntl(fd_.get(), F_GETFL);
    ::fcntl(fd_.get(), F_SETFL, flags | O_NONBLOCK);  // so that no call outlasts its timeout
}

Result<ReadSome> SocketStream::read_some(std::span<std::uint8_t> out, Milliseconds timeout) {
    while (true) {
        const ssize_t got = ::recv(fd_.get(), out.data(), out.size(), 0);
        if (got >= 0) return ReadSome{.bytes = static_cast<std::size_t>(got), .timed_out = false};
        if (errno == EINTR) continue;
        if (errno == ECONNRESET) return ReadSome{};
        if (errno != EAGAIN && errno != EWOULDBLOCK) return system_failure(name_, "read");
        if (!wait_for(fd_.get(), POLLIN, timeout)) return ReadSome{.bytes = 0, .timed_out = true};
    }
}

Status SocketStream::write_all(std::span<const std::uint8_t> bytes, Milliseconds timeout) {
    while (!bytes.empty()) {
        const ssize_t sent = ::send(fd_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent > 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(sent));
            continue;
        }
        if (errno == EINTR) continue;
        if (errno == EPIPE || errno == ECONNRESET) return Failure{name_ + ": the other end closed"};
        if (errno != EAGAIN && errno != EWOULDBLOCK) return system_failure(name_, "write");
        if (!wait_for(fd_.get(), POLLOUT, timeout))
            return Failure{name_ + ": nothing could be written for " +
                           std::to_string(timeout.count()) + " ms"};
    }
    return {};
}

void SocketStream::close() { ::shutdown(fd_.get(), SHUT_RDWR); }

}  // namespace stria

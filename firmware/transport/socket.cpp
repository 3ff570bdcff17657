#include "firmware/transport/socket.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "firmware/transport/socket_stream.h"

namespace stria {
namespace {

struct SocketAddress {
    sockaddr_storage storage{};
    socklen_t size = 0;
    const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

template <typename T>
SocketAddress stored(const T& address, std::size_t size) {
    SocketAddress result;
    std::memcpy(&result.storage, &address, sizeof address);
    result.size = static_cast<socklen_t>(size);
    return result;
}

SocketAddress system_address(const Address& address) {
    if (address.kind == Address::Kind::unix_socket) {
        sockaddr_un un{};
        un.sun_family = AF_UNIX;
        address.path.copy(un.sun_path, sizeof un.sun_path - 1);
        return stored(un, sizeof un);
    }
    if (address.host == "::1") {
        sockaddr_in6 in6{};
        in6.sin6_family = AF_INET6;
        in6.sin6_addr = in6addr_loopback;
        in6.sin6_port = htons(address.port);
        return stored(in6, sizeof in6);
    }
    sockaddr_in in{};
    in.sin_family = AF_INET;
    in.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    in.sin_port = htons(address.port);
    return stored(in, sizeof in);
}

FileDescriptor open_socket(const SocketAddress& address) {
    return FileDescriptor(
        ::socket(address.storage.ss_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

void send_at_once(int fd, const Address& address) {
    const int on = 1;
    if (address.kind == Address::Kind::tcp)
        ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
}

std::uint16_t bound_port(int fd) {
    sockaddr_storage storage{};
    socklen_t size = sizeof storage;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return 0;
    if (storage.ss_family == AF_INET6)
        return ntohs(reinterpret_cast<const sockaddr_in6*>(&storage)->sin6_port);
    return ntohs(reinterpret_cast<const sockaddr_in*>(&storage)->sin_port);
}

/// True for processes of this user and of root.
bool is_allowed(int fd) {
    ucred peer{};
    socklen_t size = sizeof peer;
    if (::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return false;
    return peer.uid == ::geteuid() || peer.uid == 0;
}

class SocketListener : public Listener {
  public:
    SocketListener(FileDescriptor fd, Address address)
        : fd_(std::move(fd)), address_(std::move(address)) {
        if (address_.kind == Address::Kind::tcp) address_.port = bound_port(fd_.get());
    }
    ~SocketListener() override {
        if (address_.kind == Address::Kind::unix_socket) ::unlink(address_.path.c_str());
    }

    Result<std::unique_ptr<ByteStream>> accept(Milliseconds timeout) override {
        if (closed_ || !wait_for(fd_.get(), POLLIN, timeout) || closed_)
            return std::unique_ptr<ByteStream>();
        FileDescriptor client(::accept4(fd_.get(), nullptr, nullptr, SOCK_CLOEXEC));
        if (!client && (errno == EAGAIN || errno == ECONNABORTED || errno == EINTR || closed_))
            return std::unique_ptr<ByteStream>();
        if (!client) return system_failure(to_string(address_), "accept");
        if (address_.kind == Address::Kind::unix_socket && !is_allowed(client.get()))
            return std::unique_ptr<ByteStream>();
        send_at_once(client.get(), address_);
        return std::unique_ptr<ByteStream>(
            std::make_unique<SocketStream>(std::move(client), to_string(address_)));
    }
    void close() override {
        closed_ = true;
        ::shutdown(fd_.get(), SHUT_RDWR);
    }
    Address address() const override { return address_; }

  private:
    FileDescriptor fd_;
    Address address_;
    std::atomic<bool> closed_ = false;
};

/// Makes room for a socket file, or says why that must not be.
Status clear_socket_path(const Address& address) {
    struct stat status {};
    if (::lstat(address.path.c_str(), &status) != 0) return {};
    if (!S_ISSOCK(status.st_mode))
        return Failure{to_string(address) + ": a file that is no socket stands there"};
    if (connect_socket(address, Milliseconds(500)).ok())
        return Failure{to_string(address) + ": another server listens there already"};
    ::unlink(address.path.c_str());
    return {};
}

}  // namespace

Result<std::unique_ptr<ByteStream>> connect_socket(const Address& address, Milliseconds timeout) {
    const std::string name = to_string(address);
    const SocketAddress target = system_address(address);
    FileDescriptor fd = open_socket(target);
    if (!fd) return system_failure(name, "socket");
    if (::connect(fd.get(), target.get(), target.size) != 0) {
        if (errno != EINPROGRESS && errno != EAGAIN)
            return system_failure(name, "nothing listens there");
        if (!wait_for(fd.get(), POLLOUT, timeout))
            return Failure{name + ": no answer within " + std::to_string(timeout.count()) + " ms"};
        int error = 0;
        socklen_t size = sizeof error;
        ::getsockopt(fd.get(), SOL_SOCKET, SO_ERROR, &error, &size);
        errno = error;
        if (error != 0) return system_failure(name, "nothing listens there");
    }
    send_at_once(fd.get(), address);
    return std::unique_ptr<ByteStream>(std::make_unique<SocketStream>(std::move(fd), name));
}

Result<std::unique_ptr<Listener>> listen_socket(const Address& address) {
    const std::string name = to_string(address);
    const bool is_unix = address.kind == Address::Kind::unix_socket;
    if (is_unix)
        if (Status clear = clear_socket_path(address); !clear) return clear.failure();
    const SocketAddress place = system_address(address);
    FileDescriptor fd = open_socket(place);
    if (!fd) return system_failure(name, "socket");
    const int on = 1;
    if (!is_unix) ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (is_unix) ::fchmod(fd.get(), S_IRUSR | S_IWUSR);  // Linux: bind() gives the file this mode
    if (::bind(fd.get(), place.get(), place.size) != 0) return system_failure(name, "bind");
    if (::listen(fd.get(), 8) != 0) return system_failure(name, "listen");
    return std::unique_ptr<Listener>(std::make_unique<SocketListener>(std::move(fd), address));
}

}  // namespace stria

#include "host/io/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <limits>

#include "host/core/errors.h"

namespace stria {
namespace {

/// A file descriptor that closes itself.
class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() { close(); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }
    bool ok() const { return fd_ >= 0; }
    int close() {
        const int fd = fd_;
        fd_ = -1;
        return fd >= 0 ? ::close(fd) : 0;
    }

  private:
    int fd_;
};

[[noreturn]] void fail(const std::string& path, const std::string& doing) {
    throw FileError(path, "", "cannot " + doing + ": " + std::strerror(errno));
}

std::string folder_of(const std::string& path) {
    const std::size_t slash = path.rfind('/');
    if (slash == std::string::npos) return ".";
    return slash == 0 ? "/" : path.substr(0, slash);
}

/// A sibling of the path, so that rename() stays inside one file system.
std::string temporary_name(const std::string& path) {
    static std::atomic<unsigned> counter{0};
    return path + ".part-" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
}

bool write_all(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(fd, bytes.data(), std::min<std::size_t>(bytes.size(), 1U << 30));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
    return true;
}

}  // namespace

std::string read_file_start(const std::string& path, std::size_t bytes) {
    Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.ok()) fail(path, "open");
    std::string start(bytes, '\0');
    std::size_t used = 0;
    while (used < bytes) {
        const ssize_t n = ::read(file.get(), start.data() + used, bytes - used);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(path, "read");
        if (n == 0) break;
        used += static_cast<std::size_t>(n);
    }
    start.resize(used);
    return start;
}

std::string read_whole_file(const std::string& path, std::size_t max_bytes) {
    Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.ok()) fail(path, "open");
    struct stat status {};
    if (::fstat(file.get(), &status) != 0) fail(path, "read");
    if (S_ISDIR(status.st_mode)) throw FileError(path, "", "expected a file, found a folder");
    const auto too_large = [&] {
        return FileError(path, "",
                         "expected at most " + std::to_string(max_bytes) + " bytes, found more");
    };
    const auto size = static_cast<std::size_t>(std::max<off_t>(status.st_size, 0));
    if (size > max_bytes) throw too_large();

    std::string bytes(size, '\0');
    std::size_t used = 0;
    for (;;) {
        if (used == bytes.size()) {  // at the stated size: is there more (a pipe, a growing file)?
            char probe = 0;
            const ssize_t n = ::read(file.get(), &probe, 1);
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) fail(path, "read");
            if (n == 0) return bytes;
            if (used >= max_bytes) throw too_large();
            bytes.resize(std::min(max_bytes, std::max<std::size_t>(4096, 2 * used)));
            bytes[used++] = probe;
        }
        const ssize_t n = ::read(file.get(), bytes.data() + used, bytes.size() - used);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(path, "read");
        used += static_cast<std::size_t>(n);
        if (n == 0) {
            bytes.resize(used);
            return bytes;
        }
    }
}

void write_whole_file(const std::string& path, std::string_view bytes) {
    const std::string temporary = temporary_name(path);
    Descriptor file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (!file.ok()) fail(path, "create");
    const bool written = write_all(file.get(), bytes) && ::fsync(file.get()) == 0 &&
                         file.close() == 0 && ::rename(temporary.c_str(), path.c_str()) == 0;
    if (!written) {
        const int why = errno;
        ::unlink(temporary.c_str());
        errno = why;
        fail(path, "write");
    }
    // The new name is on disk once its folder is.
    Descriptor folder(::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.ok()) ::fsync(folder.get());
}

}  // namespace stria

#include "firmware/stripe/large_pages.h"

#include <sys/mman.h>

#include <cerrno>
#include <cstdint>

namespace stria {

void ask_for_large_pages(void* begin, std::size_t size) {
    constexpr std::uintptr_t kPage = std::uintptr_t{1} << 21;
    const auto at = reinterpret_cast<std::uintptr_t>(begin);
    const std::uintptr_t first = (at + kPage - 1) / kPage * kPage,
                         past = (at + size) / kPage * kPage;
    if (first >= past) return;
    const int before = errno;
    madvise(static_cast<std::uint8_t*>(begin) + (first - at), past - first, MADV_HUGEPAGE);
    errno = before;
}

}  // namespace stria

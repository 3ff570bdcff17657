#pragma once
#include <cstddef>

namespace stria {

/// Asks the system to use large pages (2 MiB) where they fit into these `size` bytes, best before
/// the memory is first touched: 512 times fewer page faults, and fewer misses of the processor's
/// address cache. A wish only: contents stay, and where the system has none nothing changes.
void ask_for_large_pages(void* begin, std::size_t size);

}  // namespace stria

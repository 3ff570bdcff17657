#pragma once
#include <cstddef>
#include <functional>

namespace stria {

/// Number of threads for all parallel work of the process; 0: as many as cores. Results do not
/// depend on it.
void set_thread_count(int threads);
int thread_count();

/// Calls body(begin, end) over [0, count) cut into blocks of fixed size `grain`, on several
/// threads. Block borders depend on count and grain alone, so per-block results reduced in block
/// order are the same for any thread count. An exception from a body is rethrown.
void parallel_for_blocks(std::size_t count, std::size_t grain,
                         const std::function<void(std::size_t begin, std::size_t end)>& body);

}  // namespace stria

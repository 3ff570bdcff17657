#pragma once
#include <cstddef>
#include <functional>

namespace stria {

/// Calls run(0), run(1), ... run(blocks - 1) on several threads in no order, and returns when all
/// are done. An exception from one of them is rethrown; blocks not yet begun are then left out.
/// On oneTBB; builds with the thread sanitizer use threads of the standard library instead, because
/// the sanitizer cannot see how Debian's oneTBB, built without it, orders its work.
/// @param threads  how many, at least 1; oneTBB takes it from set_thread_count()
void run_blocks(std::size_t blocks, int threads, const std::function<void(std::size_t)>& run);

}  // namespace stria

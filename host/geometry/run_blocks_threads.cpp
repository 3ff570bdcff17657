#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "host/geometry/run_blocks.h"

namespace stria {

void run_blocks(std::size_t blocks, int threads, const std::function<void(std::size_t)>& run) {
    std::atomic<std::size_t> next = 0;
    std::mutex mutex;
    std::exception_ptr failure;
    const auto work = [&] {
        for (std::size_t block = next++; block < blocks; block = next++) {
            try {
                run(block);
            } catch (...) {
                const std::lock_guard<std::mutex> lock(mutex);
                if (!failure) failure = std::current_exception();
                next = blocks;
            }
        }
    };
    const std::size_t count = std::min(blocks, static_cast<std::size_t>(std::max(threads, 1)));
    {
        std::vector<std::jthread> workers;
        for (std::size_t i = 1; i < count; ++i) workers.emplace_back(work);
        work();
    }
    if (failure) std::rethrow_exception(failure);
}

}  // namespace stria

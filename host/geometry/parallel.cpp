#include "host/geometry/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>

#include "host/geometry/run_blocks.h"

namespace stria {
namespace {

std::atomic<int> requested = 0;  // 0: as many as cores
std::mutex limit_mutex;
std::unique_ptr<tbb::global_control> limit;

}  // namespace

void set_thread_count(int threads) {
    if (threads < 0)
        throw std::invalid_argument("set_thread_count: threads = " + std::to_string(threads) +
                                    ", expected 0 (all cores) or more");
    const std::lock_guard<std::mutex> lock(limit_mutex);
    requested = threads;
    limit.reset();
    if (threads > 0)
        limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                      static_cast<std::size_t>(threads));
}

int thread_count() {
    const int threads = requested;
    return threads > 0 ? threads : tbb::info::default_concurrency();
}

void parallel_for_blocks(std::size_t count, std::size_t grain,
                         const std::function<void(std::size_t begin, std::size_t end)>& body) {
    if (grain == 0) throw std::invalid_argument("parallel_for_blocks: grain = 0, expected >= 1");
    const std::size_t blocks = count / grain + (count % grain != 0 ? 1 : 0);
    const auto run = [&](std::size_t block) {
        body(block * grain, std::min(count, (block + 1) * grain));
    };
    if (blocks < 2 || thread_count() == 1) {
        for (std::size_t block = 0; block < blocks; ++block) run(block);
        return;
    }
    run_blocks(blocks, thread_count(), run);
}

}  // namespace stria

#include <tbb/parallel_for.h>

#include "host/geometry/run_blocks.h"

namespace stria {

void run_blocks(std::size_t blocks, int /*threads*/, const std::function<void(std::size_t)>& run) {
    tbb::parallel_for(std::size_t{0}, blocks, run);
}

}  // namespace stria

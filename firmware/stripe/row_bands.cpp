#include "firmware/stripe/row_bands.h"

#include <algorithm>
#include <thread>
#include <vector>

namespace stria {

void for_row_bands(int height, int threads, const std::function<void(int, int)>& work) {
    const int bands = std::clamp(threads, 1, std::max(height, 1));
    std::vector<std::jthread> others;
    for (int band = 1; band < bands; ++band)
        others.emplace_back(work, height * band / bands, height * (band + 1) / bands);
    work(0, height / bands);
}

}  // namespace stria

#pragma once
#include <functional>

namespace stria {

/// Calls work(begin, end) for `threads` bands of rows that together are [0, height), each on its
/// own thread (one band: on the caller's). Work must not throw.
void for_row_bands(int height, int threads, const std::function<void(int begin, int end)>& work);

}  // namespace stria

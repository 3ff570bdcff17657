#pragma once
#include <cassert>
#include <cstddef>

namespace stria {

/// Borrowed pixels of a row-major image: (width, height), row(y)[x]. T may be const.
template <typename T>
struct ImageView {
    T* data = nullptr;
    int width = 0;
    int height = 0;
    std::ptrdiff_t stride = 0;  ///< elements from one row to the next

    T* row(int y) const {
        assert(y >= 0 && y < height);
        return data + y * stride;
    }
    T& at(int x, int y) const {
        assert(x >= 0 && x < width);
        return row(y)[x];
    }
    bool empty() const { return width == 0 || height == 0; }
};

}  // namespace stria

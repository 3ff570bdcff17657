#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "firmware/core/image_view.h"

namespace stria {

/// An owned image, row-major, `channels` interleaved values a pixel; (width, height), at(x, y, c).
template <typename T>
struct Image {
    int width = 0;
    int height = 0;
    int channels = 1;
    std::vector<T> values;

    Image() = default;
    Image(int w, int h, int c = 1, T fill = T{})
        : width(w),
          height(h),
          channels(c),
          values(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) *
                     static_cast<std::size_t>(c),
                 fill) {}

    std::size_t index(int x, int y, int c = 0) const {
        return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)) *
                   static_cast<std::size_t>(channels) +
               static_cast<std::size_t>(c);
    }
    T& at(int x, int y, int c = 0) { return values[index(x, y, c)]; }
    const T& at(int x, int y, int c = 0) const { return values[index(x, y, c)]; }
    /// Of a one-channel image.
    ImageView<const T> view() const { return {values.data(), width, height, width}; }
    ImageView<T> view() { return {values.data(), width, height, width}; }
    bool empty() const { return values.empty(); }
};

using GreyImage = Image<std::uint8_t>;  ///< 1 channel
using Grey16Image = Image<std::uint16_t>;
using ColourImage = Image<std::uint8_t>;  ///< 3 channels R G B

}  // namespace stria

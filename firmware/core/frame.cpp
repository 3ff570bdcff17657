#include "firmware/core/frame.h"

namespace stria {

void resize(Frame& frame, int width, int height, int bits) {
    frame.width = width;
    frame.height = height;
    frame.bits = bits;
    frame.bytes.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                       static_cast<std::size_t>(frame.bytes_per_sample()));
}

}  // namespace stria

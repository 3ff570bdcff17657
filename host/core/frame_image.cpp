#include "host/core/frame_image.h"

#include <stdexcept>
#include <string>

namespace stria {
namespace {

template <typename T>
void transpose_into(ImageView<const T> from, T* to) {
    for (int x = 0; x < from.width; ++x)
        for (int y = 0; y < from.height; ++y) *to++ = from.at(x, y);
}

}  // namespace

Frame frame_from_image(const Grey16Image& image, int bits) {
    if (bits < 8 || bits > 16 || image.channels != 1)
        throw std::invalid_argument("frame_from_image: " + std::to_string(bits) + " bits, " +
                                    std::to_string(image.channels) +
                                    " channels: expected 8 to 16 and 1");
    Frame frame;
    resize(frame, image.width, image.height, bits);
    frame.laser_power = 1;
    if (bits == 8) {
        for (std::size_t i = 0; i < image.values.size(); ++i)
            frame.bytes[i] = static_cast<std::uint8_t>(image.values[i]);
    } else {
        auto* samples = reinterpret_cast<std::uint16_t*>(frame.bytes.data());
        for (std::size_t i = 0; i < image.values.size(); ++i) samples[i] = image.values[i];
    }
    return frame;
}

Grey16Image image_from_frame(const Frame& frame) {
    Grey16Image image(frame.width, frame.height);
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
            image.at(x, y) = static_cast<std::uint16_t>(frame.sample(x, y));
    return image;
}

Frame transposed(const Frame& frame) {
    Frame out = frame;
    resize(out, frame.height, frame.width, frame.bits);
    if (frame.bits > 8)
        transpose_into(frame.view16(), reinterpret_cast<std::uint16_t*>(out.bytes.data()));
    else
        transpose_into(frame.view8(), out.bytes.data());
    return out;
}

}  // namespace stria

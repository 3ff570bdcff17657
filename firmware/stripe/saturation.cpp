#include "firmware/stripe/saturation.h"

namespace stria {

std::uint32_t count_saturated(const Frame& frame) {
    const auto full = frame.full_scale();
    std::uint32_t count = 0;
    for (int y = 0; y < frame.height; ++y) {
        if (frame.bits > 8) {
            const std::uint16_t* row = frame.view16().row(y);
            for (int x = 0; x < frame.width; ++x) count += row[x] >= full;
        } else {
            const std::uint8_t* row = frame.view8().row(y);
            for (int x = 0; x < frame.width; ++x) count += row[x] >= full;
        }
    }
    return count;
}

}  // namespace stria

#include <algorithm>

#include "firmware/stripe/fast_kernels.h"

namespace stria::fast {

RowState advance_row_plainly(const std::uint8_t* const* rows, int count, int width,
                             const RowPlanes& planes, const DetectionLevels& levels,
                             const WindowLimits& limits, std::vector<Closed>& closed) {
    RowState state;
    for (int x = 0; x < width; ++x) {
        std::uint32_t sum = 0;
        int age = planes.age[x], quiet = planes.quiet[x];
        for (int k = 0; k < count; ++k) {
            const std::uint8_t sample = rows[k][x];
            const bool above = sample > planes.threshold[x];
            sum += sample;
            state.saturated_samples += sample == 255;
            if (age == 0 && !above) continue;
            quiet = above ? 0 : quiet + 1;
            ++age;
            const int last = age - 1 - quiet;
            if (age - 1 >= limits.max_pulse_frames) {  // no pulse but another light
                planes.set_background(x, std::uint32_t{sample} << 8);
                age = 0;
            } else if (!above && quiet >= margin_frames(last, limits)) {
                closed.push_back(planes.closed(x, k, last));
                age = 0;
            }
        }
        planes.age[x] = static_cast<std::uint8_t>(age);
        state.oldest = std::max(state.oldest, age);
        planes.quiet[x] = static_cast<std::uint8_t>(quiet);
        if (age == 0) planes.set_background(x, levels.follow(planes.background(x), sum, count));
        planes.threshold[x] = static_cast<std::uint8_t>(levels.threshold(planes.background(x)));
    }
    return state;
}

}  // namespace stria::fast

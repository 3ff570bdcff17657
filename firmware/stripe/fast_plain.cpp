#include <algorithm>

#include "firmware/stripe/fast_kernels.h"

namespace stria::fast {

RowState advance_row_plainly(const std::uint8_t* const* rows, int count, int width,
                             const RowPlanes& planes, const DetectionLevels& levels,
                             const WindowLimits& limits, std::uint8_t number,
                             std::vector<Closed>& others) {
    RowState state;
    for (int x = 0; x < width; ++x) {
        std::uint32_t sum = 0;
        int age = planes.age[x], quiet = planes.quiet[x];
        const std::uint32_t threshold = levels.threshold(planes.background(x));
        for (int k = 0; k < count; ++k) {
            const std::uint8_t sample = rows[k][x];
            const bool above = sample > threshold;
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
                const auto behind = static_cast<std::uint8_t>(number + k + 1);
                if (!planes.let_wait(x, threshold, last, behind))
                    others.push_back(planes.closed(x, threshold, last, behind));
                age = 0;
            }
        }
        planes.age[x] = static_cast<std::uint8_t>(age);
        if (x % kLanes == 0) planes.lower(x, kOpen);
        if (age > 0) planes.raise(x, kOpen);
        state.oldest = std::max(state.oldest, age);
        planes.quiet[x] = static_cast<std::uint8_t>(quiet);
        if (age == 0) planes.set_background(x, levels.follow(planes.background(x), sum, count));
    }
    return state;
}

void set_backgrounds_plainly(const std::uint8_t* const* rows, int count, int begin, int end,
                             const RowPlanes& planes, const DetectionLevels& levels) {
    for (int x = begin; x < end; ++x) {
        DetectionLevels::FirstSamples samples(rows[0][x]);
        for (int k = 1; k < count; ++k) samples.add(rows[k][x]);
        planes.set_background(x, levels.first(samples));
    }
}

}  // namespace stria::fast

#include "sim/machine.h"

#include <limits>
#include <span>

#include "host/geometry/parallel.h"
#include "sim/sensor.h"

namespace stria {

Machine::Machine(const Scene& given, std::uint64_t mixed_seed)
    : scene(given),
      seed(mixed_seed),
      geometry(scene),
      light(scene, geometry),
      motion((scene.axis.min + scene.axis.max) / 2),
      exposure_ns(ns_from_us(scene.sensor.exposure_us)),
      period_ns(std::max(exposure_ns, ns_from_us(scene.sensor.min_frame_period_us))) {}

TimeNs Machine::interlock_opens_ns() const {
    const double at = scene.fault.interlock_opens_at_s;
    return at < 0 || at > 9e9 ? std::numeric_limits<TimeNs>::max()
                              : static_cast<TimeNs>(std::llround(at * 1e9));
}

float Machine::power_at(TimeNs time) const {
    if (time >= interlock_opens_ns()) return 0;
    float power = 0;
    for (const PowerChange& change : powers)
        if (change.time <= time) power = change.power;
    return power;
}

TimeNs Machine::readout_ns() const {
    return ns_from_us(scene.sensor.row_time_us) * (scene.channel.camera.height - 1);
}

/// Cuts [begin, end) where laser or axis change, so that each part is steady.
void Machine::add_exposures(TimeNs begin, TimeNs end, std::vector<Exposure>& out) const {
    std::vector<TimeNs> cuts = motion.corners(begin, end);
    for (const PowerChange& change : powers) cuts.push_back(change.time);
    cuts.push_back(interlock_opens_ns());
    cuts.push_back(begin);
    cuts.push_back(end);
    std::sort(cuts.begin(), cuts.end());
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
        const TimeNs from = cuts[i], to = cuts[i + 1];
        if (from < begin || to > end || from == to) continue;
        const float power = power_at(from);
        if (power > 0)
            out.push_back({motion.position(from), motion.position(to),
                           static_cast<double>(to - from) * 1e-9 * static_cast<double>(power)});
    }
}

Machine::Shot Machine::plan_shot(TimeNs true_start, std::int64_t number) const {
    Shot shot;
    shot.number = number;
    shot.seconds = static_cast<double>(exposure_ns) * 1e-9;
    const TimeNs end = true_start + exposure_ns + readout_ns();
    shot.s_middle = (motion.position(true_start) + motion.position(end)) / 2;
    shot.travel = std::abs(motion.position(end) - motion.position(true_start));
    const TimeNs row_ns = ns_from_us(scene.sensor.row_time_us);
    if (row_ns == 0) {
        add_exposures(true_start, true_start + exposure_ns, shot.exposures);
        return shot;
    }
    // Rolling shutter: the same number of exposures for every row, empty ones of no duration.
    shot.rows_apart = scene.channel.camera.height;
    std::vector<std::vector<Exposure>> rows(static_cast<std::size_t>(shot.rows_apart));
    std::size_t most = 0;
    for (std::size_t y = 0; y < rows.size(); ++y) {
        const TimeNs begin = true_start + static_cast<TimeNs>(y) * row_ns;
        add_exposures(begin, begin + exposure_ns, rows[y]);
        most = std::max(most, rows[y].size());
    }
    for (std::size_t y = 0; y < rows.size(); ++y) {
        const double s = motion.position(true_start + static_cast<TimeNs>(y) * row_ns);
        rows[y].resize(most, Exposure{s, s, 0});
        shot.exposures.insert(shot.exposures.end(), rows[y].begin(), rows[y].end());
    }
    return shot;
}

void Machine::render(const Shot& shot, Frame& frame) {
    std::vector<LightBlock> of_this_frame;
    const std::vector<LightBlock>* blocks = &swept_light_;
    if (scene.channel.axis.kind == MachineKind::swept) {
        if (swept_light_view_ != view) swept_light_ = light.whole_sweep();
        swept_light_view_ = view;
    } else {
        of_this_frame = light.around(shot.s_middle, shot.travel);
        blocks = &of_this_frame;
    }
    parallel_for_blocks(blocks->size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) render_block((*blocks)[b], shot, frame);
    });
}

void Machine::render_block(const LightBlock& block, const Shot& shot, Frame& frame) const {
    std::vector<float> electrons(block.ambient.size());
    const auto seconds = static_cast<float>(shot.seconds);
    for (std::size_t i = 0; i < electrons.size(); ++i) electrons[i] = block.ambient[i] * seconds;

    std::span<const Exposure> exposures = shot.exposures;
    const int rows = shot.rows_apart > 0 ? block.row_end - block.row_begin : 0;
    if (rows > 0) {
        const std::size_t each = exposures.size() / static_cast<std::size_t>(shot.rows_apart);
        exposures = exposures.subspan(static_cast<std::size_t>(block.row_begin) * each,
                                      static_cast<std::size_t>(rows) * each);
    }
    add_stripe(block, frame.width, exposures, rows, electrons);
    const std::size_t first =
        static_cast<std::size_t>(block.row_begin) * static_cast<std::size_t>(frame.width);
    digitise(scene.sensor, noise_key(seed, view, shot.number), static_cast<std::uint32_t>(first),
             electrons,
             frame.bytes.data() + first * static_cast<std::size_t>(frame.bytes_per_sample()));
}

}  // namespace stria

#include "sim/machine.h"

#include <limits>
#include <numbers>
#include <span>

#include "host/geometry/parallel.h"
#include "sim/blooming.h"
#include "sim/random.h"
#include "sim/screen_speckle.h"
#include "sim/sensor.h"

namespace stria {

Machine::Machine(const Scene& given, std::uint64_t mixed_seed)
    : scene(given),
      seed(mixed_seed),
      geometry(scene),
      light(scene, geometry, mixed_seed),
      motion((scene.axis.min + scene.axis.max) / 2),
      exposure_ns(ns_from_us(scene.sensor.exposure_us)),
      period_ns(std::max(exposure_ns, ns_from_us(scene.sensor.min_frame_period_us))),
      pattern_(pixel_pattern(scene, mixed_seed)) {
    if (scene.speckle.model == SpeckleModel::screen)
        laser_gain_ = screen_speckle(scene, mixed_seed);
    if (is_blurred(scene.lens)) blur_ = std::make_unique<Blur>();
}

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

double Machine::true_position(TimeNs time) const {
    const double logged = motion.position(time - ns_from_us(scene.axis.lag_us));
    if (scene.axis.periodic_error == 0) return logged;
    return logged + scene.axis.periodic_error *
                        std::sin(2 * std::numbers::pi * logged / scene.axis.periodic_length);
}

TimeNs Machine::readout_ns() const {
    return ns_from_us(scene.sensor.row_time_us) * (scene.channel.camera.height - 1);
}

/// Cuts [begin, end) where laser or axis change, so that each part is steady.
void Machine::add_exposures(TimeNs begin, TimeNs end, std::vector<Exposure>& out) const {
    const TimeNs lag = ns_from_us(scene.axis.lag_us);
    std::vector<TimeNs> cuts = motion.corners(begin - lag, end - lag);
    for (TimeNs& cut : cuts) cut += lag;
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
            out.push_back({true_position(from), true_position(to),
                           static_cast<double>(to - from) * 1e-9 * static_cast<double>(power)});
    }
}

namespace {

/// Shifts a frame along the axis.
void move(Machine::Shot& shot, double by) {
    shot.s_middle += by;
    for (Exposure& exposure : shot.exposures) {
        exposure.s_begin += by;
        exposure.s_end += by;
    }
}

}  // namespace

double Machine::wobble_of(std::int64_t number) const {
    if (scene.axis.wobble == 0) return 0;
    return scene.axis.wobble * counter_random::normal(seed, counter_random::kAxisWobble,
                                                      static_cast<std::uint64_t>(number));
}

Machine::Shot Machine::plan_shot(TimeNs true_start, std::int64_t number) const {
    Shot shot;
    shot.number = number;
    shot.seconds = static_cast<double>(exposure_ns) * 1e-9;
    shot.ambient_seconds = ambient_seconds(true_start);
    const TimeNs end = true_start + exposure_ns + readout_ns();
    shot.s_middle = (true_position(true_start) + true_position(end)) / 2;
    shot.travel = std::abs(true_position(end) - true_position(true_start));
    const TimeNs row_ns = ns_from_us(scene.sensor.row_time_us);
    if (row_ns == 0) {
        add_exposures(true_start, true_start + exposure_ns, shot.exposures);
        move(shot, wobble_of(number));
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
        const double s = true_position(true_start + static_cast<TimeNs>(y) * row_ns);
        rows[y].resize(most, Exposure{s, s, 0});
        shot.exposures.insert(shot.exposures.end(), rows[y].begin(), rows[y].end());
    }
    move(shot, wobble_of(number));
    return shot;
}

/// What steady light of the same mean would need to shine for, seconds: the integral over each
/// row's exposure of 1 + depth cos(2 pi hz t), in closed form.
std::vector<float> Machine::ambient_seconds(TimeNs true_start) const {
    const double seconds = static_cast<double>(exposure_ns) * 1e-9;
    const double depth = scene.flicker.depth;
    const TimeNs row_ns = ns_from_us(scene.sensor.row_time_us);
    if (depth == 0) return {static_cast<float>(seconds)};
    const double omega = 2 * std::numbers::pi * scene.flicker.hz;
    const double half = omega * seconds / 2;
    std::vector<float> rows(row_ns > 0 ? static_cast<std::size_t>(scene.channel.camera.height) : 1);
    for (std::size_t y = 0; y < rows.size(); ++y) {
        const TimeNs middle = true_start + static_cast<TimeNs>(y) * row_ns + exposure_ns / 2;
        const double phase =
            std::remainder(omega * 1e-9 * static_cast<double>(middle), 2 * std::numbers::pi);
        rows[y] =
            static_cast<float>(seconds * (1 + depth * std::sin(half) / half * std::cos(phase)));
    }
    return rows;
}

void Machine::render(const Shot& shot, Frame& frame) {
    std::vector<LightBlock> of_this_frame;
    const std::vector<LightBlock>* blocks = &swept_light_;
    bool is_new = true;
    if (scene.channel.axis.kind == MachineKind::swept) {
        is_new = swept_light_view_ != view;
        if (is_new) swept_light_ = light.whole_sweep();
        if (is_new) reflected_light_ = light.reflected_sweep(scene);
        swept_light_view_ = view;
    } else {
        of_this_frame = light.around(shot.s_middle, shot.travel);
        blocks = &of_this_frame;
    }
    if (blur_) {
        if (is_new) spread_ambient(*blocks, frame.width, frame.height);
        render_blurred(*blocks, shot, frame);
        return;
    }
    parallel_for_blocks(blocks->size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) render_sharp((*blocks)[b], shot, frame);
    });
}

void Machine::add_laser(const LightBlock& block, const Shot& shot, int width,
                        std::span<float> electrons) const {
    std::span<const Exposure> exposures = shot.exposures;
    const int rows = shot.rows_apart > 0 ? block.row_end - block.row_begin : 0;
    if (rows > 0) {
        const std::size_t each = exposures.size() / static_cast<std::size_t>(shot.rows_apart);
        exposures = exposures.subspan(static_cast<std::size_t>(block.row_begin) * each,
                                      static_cast<std::size_t>(rows) * each);
    }
    add_stripe(block, width, exposures, rows, electrons);
    for (const LightBlock& reflected : reflected_light_)
        if (reflected.row_begin == block.row_begin)
            add_stripe(reflected, width, exposures, rows, electrons);
}

void Machine::grain(std::span<float> laser, int row_begin, int width) const {
    const float* gain =
        laser_gain_.data() + static_cast<std::size_t>(row_begin) * static_cast<std::size_t>(width);
    for (std::size_t i = 0; i < laser.size(); ++i) laser[i] *= gain[i];
}

void Machine::convert(std::span<float> electrons, int row_begin, const Shot& shot,
                      Frame& frame) const {
    const std::size_t first =
        static_cast<std::size_t>(row_begin) * static_cast<std::size_t>(frame.width);
    if (!pattern_.gain.empty())
        for (std::size_t i = 0; i < electrons.size(); ++i) electrons[i] *= pattern_.gain[first + i];
    const auto dark = static_cast<float>(scene.sensor.dark_current_e_per_s * shot.seconds);
    if (dark > 0)
        for (float& e : electrons) e += dark;
    if (scene.sensor.blooming > 0)
        for (std::size_t row = 0; row < electrons.size();
             row += static_cast<std::size_t>(frame.width))
            spill_along_row(electrons.subspan(row, static_cast<std::size_t>(frame.width)),
                            static_cast<float>(scene.sensor.full_well_e),
                            static_cast<float>(scene.sensor.blooming));
    std::span<const float> offset;
    if (!pattern_.offset_e.empty())
        offset = std::span(pattern_.offset_e).subspan(first, electrons.size());
    digitise(scene.sensor, noise_key(seed, view, shot.number), static_cast<std::uint32_t>(first),
             electrons,
             frame.bytes.data() + first * static_cast<std::size_t>(frame.bytes_per_sample()),
             offset);
}

namespace {

/// Adds steady light, each row as long as it was exposed.
void add_ambient(std::span<const float> per_second, const std::vector<float>& seconds, int width,
                 int row_begin, std::span<float> electrons) {
    const auto row_size = static_cast<std::size_t>(width);
    for (std::size_t begin = 0; begin < electrons.size(); begin += row_size) {
        const std::size_t row = static_cast<std::size_t>(row_begin) + begin / row_size;
        const float time = seconds.size() > 1 ? seconds[row] : seconds[0];
        for (std::size_t i = begin; i < begin + row_size; ++i) electrons[i] += per_second[i] * time;
    }
}

}  // namespace

void Machine::render_sharp(const LightBlock& block, const Shot& shot, Frame& frame) const {
    std::vector<float> electrons(block.ambient.size());
    if (!laser_gain_.empty()) {
        add_laser(block, shot, frame.width, electrons);
        grain(electrons, block.row_begin, frame.width);
    }
    add_ambient(block.ambient, shot.ambient_seconds, frame.width, block.row_begin, electrons);
    if (laser_gain_.empty()) add_laser(block, shot, frame.width, electrons);
    convert(electrons, block.row_begin, shot, frame);
}

void Machine::spread_ambient(const std::vector<LightBlock>& blocks, int width, int height) {
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    std::vector<float> sharp;
    sharp.reserve(pixels);
    blur_->spots.clear();
    for (const LightBlock& block : blocks) {
        sharp.insert(sharp.end(), block.ambient.begin(), block.ambient.end());
        blur_->spots.insert(blur_->spots.end(), block.spots.begin(), block.spots.end());
    }
    blur_->ambient.assign(pixels, 0.0F);
    parallel_for_blocks(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const auto first =
                static_cast<std::size_t>(blocks[b].row_begin) * static_cast<std::size_t>(width);
            blur_->spread.gather(
                sharp, blur_->spots, width, height, blocks[b].row_begin, blocks[b].row_end,
                std::span(blur_->ambient).subspan(first, blocks[b].ambient.size()));
        }
    });
}

/// Light keeps the time of the row that it would have reached without the lens's spread.
void Machine::render_blurred(const std::vector<LightBlock>& blocks, const Shot& shot,
                             Frame& frame) {
    blur_->laser.assign(blur_->ambient.size(), 0.0F);
    const auto part = [&](std::vector<float>& picture, const LightBlock& block) {
        const auto first =
            static_cast<std::size_t>(block.row_begin) * static_cast<std::size_t>(frame.width);
        return std::span(picture).subspan(first, block.ambient.size());
    };
    parallel_for_blocks(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b)
            add_laser(blocks[b], shot, frame.width, part(blur_->laser, blocks[b]));
    });
    parallel_for_blocks(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            const LightBlock& block = blocks[b];
            std::vector<float> electrons(block.ambient.size());
            const auto gather_laser = [&] {
                blur_->spread.gather(blur_->laser, blur_->spots, frame.width, frame.height,
                                     block.row_begin, block.row_end, electrons);
            };
            if (!laser_gain_.empty()) {
                gather_laser();
                grain(electrons, block.row_begin, frame.width);
            }
            add_ambient(part(blur_->ambient, block), shot.ambient_seconds, frame.width,
                        block.row_begin, electrons);
            if (laser_gain_.empty()) gather_laser();
            convert(electrons, block.row_begin, shot, frame);
        }
    });
}

}  // namespace stria

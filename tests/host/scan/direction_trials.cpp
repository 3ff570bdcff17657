#include "tests/host/scan/direction_trials.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "firmware/stripe/spacetime.h"
#include "host/core/laser_sheet.h"
#include "host/scan/merge_passes.h"
#include "host/scan/range_from_pulses.h"
#include "tests/host/scan/ghost_trials.h"

namespace stria::test {
namespace {

constexpr double kStep = 0.45e-3;  // rad
constexpr std::uint16_t kWarnings =
    kPulseOverlapping | kPulseGhostSuspected | kPulseWidthOutOfRange | kPulseTouchesSequenceEnd;

PulseMap pulses_in(const SimSweep& sweep, const Scene& scene) {
    const Frame& first = sweep.frames.front();
    SpacetimeAnalyser analyser(
        first.width, first.height, first.bits,
        {scene.sensor.gain_e_per_dn, scene.sensor.read_noise_e, scene.sensor.black_dn},
        {.threads = 2});
    AxisLog log;
    for (std::size_t k = 0; k < sweep.frames.size(); ++k) {
        analyser.add(sweep.frames[k]);
        log.samples.push_back({sweep.frames[k].row_time(0), sweep.s[k]});
    }
    PulseMap map = analyser.finish();
    assign_axis_positions(map, log);
    return map;
}

}  // namespace

SimSweep sweep(const Scene& scene, unsigned seed, bool back) {
    SimulatedScanner scanner(scene, seed);
    const double from = scene.axis.min, to = scene.axis.max;
    return back ? record_sweep(scanner, to, from, kStep) : record_sweep(scanner, from, to, kStep);
}

Outcome outcome_of(const SimSweep& there, const Scene& seen_there, const SimSweep& back,
                   const Scene& seen_back) {
    std::vector<PulseMap> passes = {pulses_in(there, seen_there), pulses_in(back, seen_back)};
    const SceneSensor& sensor = seen_there.sensor;
    const SensorNoise noise{sensor.gain_e_per_dn, sensor.read_noise_e, sensor.black_dn};
    const auto told = compare_directions(
        passes, {.from = seen_there.axis.min, .to = seen_there.axis.max, .noise = noise});
    EXPECT_TRUE(told);
    Outcome outcome;
    if (!told) return outcome;
    outcome.told = *told;
    const SceneGeometry truth_there(seen_there), truth_back(seen_back);
    const ScannerModel model = SimulatedScanner(seen_there, 0).truth_model();
    const RangeImage image =
        range_from_pulses(merge_passes(passes, PassGrid::image, "scan", told->axis_sigma_s), model,
                          {.directions_compared = true})
            .image;
    const Channel& channel = model.channels.front();
    const Rigid3 camera_from_scan = scan_from_camera(channel, 0).inverse();
    for (std::size_t i = 0; i < image.cell_count(); ++i) {
        if (!image.mask[i]) continue;
        const RangePoint& point = image.points[i];
        const double beam_mm =
            sigma_at(sheet_at(channel, point.s), camera_from_scan * point.position);
        const double allowed = std::max(5 * static_cast<double>(point.sigma_mm), beam_mm / 2);
        const double error = std::max(distance_in_pixel(truth_there, channel, i, point),
                                      distance_in_pixel(truth_back, channel, i, point));
        const bool is_wrong = error > allowed;
        const bool is_flagged = (point.flags & kWarnings) != 0;
        (is_wrong ? outcome.wrong : outcome.right) += 1;
        (is_wrong ? outcome.wrong_flagged : outcome.right_flagged) += is_flagged;
        outcome.missed += is_wrong && !is_flagged && point.intensity >= 6;
    }
    std::printf(
        "pulses: %zu agree, %zu unseen, %zu displaced, %zu untold; points: %zu right, %zu of them "
        "flagged, %zu wrong, %zu of them flagged, %zu missed at 6 DN or more\n",
        told->agreeing, told->unseen, told->displaced, told->untold, outcome.right,
        outcome.right_flagged, outcome.wrong, outcome.wrong_flagged, outcome.missed);
    return outcome;
}

}  // namespace stria::test

#include "host/cli/recording_range.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>

#include "firmware/stripe/path_spacetime.h"
#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"
#include "host/cli/fast_analysis.h"
#include "host/core/errors.h"
#include "host/geometry/parallel.h"
#include "host/io/model_io.h"
#include "host/scan/clock_delay.h"
#include "host/scan/compare_directions.h"
#include "host/scan/merge_passes.h"
#include "host/scan/path_table.h"

namespace stria {
namespace {

[[noreturn]] void refuse_undersampled(const std::string& name) {
    throw Error(
        name +
        ": the sweep is undersampled: its step exceeds the stripe's width, so no pulse can be "
        "trusted; scan again with a smaller step");
}

using Pass = std::span<const Frame>;

/// True if the axis goes from high to low positions at the frame; over a frame's period, because
/// between two neighbouring positions of a log its own noise decides.
bool goes_back(const Frame& frame, const AxisLog& log, TimeNs period_ns) {
    const auto before = position_at(log, frame.row_time(0) - period_ns / 2);
    const auto after = position_at(log, frame.row_time(0) + period_ns / 2);
    return before && after && after->s < before->s;
}

/// The laser-on frames of each pass of the axis, in order.
std::vector<Pass> passes_of(const RecordingContents& recording) {
    const std::vector<Frame>& frames = recording.frames;
    const TimeNs period_ns = frames.size() < 2 ? 0 : frames[1].row_time(0) - frames[0].row_time(0);
    const bool turns = recording.snapshot.plan.both_directions;
    std::vector<Pass> passes;
    std::size_t first = 0;
    bool back = false;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const bool same = frames[i].laser_id == frames[first].laser_id &&
                          frames[i].exposure_index == frames[first].exposure_index;
        const bool now_back = turns && goes_back(frames[i], recording.axis_log, period_ns);
        if (i > first && (!same || now_back != back)) {
            passes.emplace_back(&frames[first], i - first);
            first = i;
        }
        back = now_back;
    }
    if (!frames.empty()) passes.emplace_back(&frames[first], frames.size() - first);
    return passes;
}

/// The axis must be known at a frame's own time; frames before and after the log tell nothing.
PulseMap along_paths(const RecordingContents& recording, Pass frames, const ScannerModel& model,
                     const std::string& name) {
    const Frame& first = frames.front();
    const Channel* channel = find_channel(model, first.camera_id, first.laser_id);
    if (!channel) throw Error(name + ": the scanner model has no channel for its camera and laser");
    PathOptions options;
    options.threads = thread_count();
    PathAnalyser analyser(make_path_table(*channel, model_hash(model)), first.bits,
                          recording.snapshot.device.noise, options);
    for (const Frame& frame : frames)
        if (const auto axis = position_at(recording.axis_log, frame.row_time(0)))
            analyser.add(frame, *axis);
    return analyser.finish();
}

/// Analyses the recorded frames of a pass as the plan says.
PulseMap analysed(const RecordingContents& recording, Pass frames, const std::string& name,
                  const ScannerModel* model) {
    const Frame& first = frames.front();
    const SensorNoise& noise = recording.snapshot.device.noise;
    if (recording.snapshot.plan.mode == StripeMode::spatial) {
        SpatialAnalyser analyser(first.height, noise);
        for (const Frame& frame : frames) analyser.add(frame);
        return analyser.finish();
    }
    if (recording.snapshot.device.kind != name_of(MachineKind::swept)) {
        if (!model)
            throw Error(name + ": spacetime frames of a " + recording.snapshot.device.kind +
                        " follow image paths, which need a calibrated model: expected a sweep with "
                        "mode = \"spatial\" in its plan");
        return along_paths(recording, frames, *model, name);
    }
    SpacetimeAnalyser analyser(
        first.width, first.height, first.bits, noise,
        {.threads = thread_count(), .fast = was_fast_analysis(recording.snapshot)});
    for (const Frame& frame : frames) analyser.add(frame);
    return analyser.finish();
}

std::vector<PulseMap> analysed(const RecordingContents& recording, const std::string& name,
                               const ScannerModel* model) {
    const std::vector<Pass> passes = passes_of(recording);
    if (passes.empty()) throw Error(name + ": holds neither pulses nor laser-on frames");
    std::vector<PulseMap> maps;
    for (const Pass pass : passes) {
        maps.push_back(analysed(recording, pass, name, model));
        assign_axis_positions(maps.back(), recording.axis_log);
    }
    return maps;
}

PassGrid grid_of(const RecordingContents& recording) {
    return recording.snapshot.plan.mode == StripeMode::spatial ||
                   recording.snapshot.device.kind != name_of(MachineKind::swept)
               ? PassGrid::frames
               : PassGrid::image;
}

/// The maps of the passes with their positions, which the device wrote, or which `delay_ns` asks
/// for anew.
std::vector<PulseMap> passes_with_positions(const RecordingContents& recording,
                                            const std::string& name, const ScannerModel* model,
                                            double delay_ns) {
    const bool from_device = !recording.pulse_maps.empty();
    std::vector<PulseMap> maps =
        from_device ? recording.pulse_maps : analysed(recording, name, model);
    for (PulseMap& map : maps) {
        if (map.undersampled) refuse_undersampled(name);
        if (delay_ns != 0) assign_axis_positions(map, recording.axis_log, delay_ns);
    }
    return maps;
}

/// What two directions say of the clocks, applied where it matters and is certain.
std::string correct_delay(std::vector<PulseMap>& passes) {
    constexpr double kCertain = 5;  // standard deviations
    const auto delay = clock_delay(passes);
    if (!delay) return "";
    const bool certain = std::abs(delay->delay_ns) > kCertain * delay->sigma_ns;
    if (certain)
        for (PulseMap& map : passes) apply_delay(map, delay->delay_ns);
    char text[200];
    std::snprintf(
        text, sizeof text,
        "two directions of the axis: clock delay %.2f us, standard deviation %.2f us, from "
        "%zu cells: %s",
        1e-3 * delay->delay_ns, 1e-3 * delay->sigma_ns, delay->cells,
        certain ? "corrected; the calibration should know it" : "none to correct");
    return text;
}

/// What the directions of a whole swept sweep say of each other's pulses, which it flags.
std::optional<DirectionComparison> compare(std::vector<PulseMap>& passes,
                                           const RecordingContents& recording) {
    const ScanPlan& plan = recording.snapshot.plan;
    const bool is_whole = recording.end && recording.end->complete;
    if (!plan.both_directions || !is_whole || grid_of(recording) != PassGrid::image) return {};
    return compare_directions(
        passes, {.from = plan.from, .to = plan.to, .noise = recording.snapshot.device.noise});
}

}  // namespace

PulseMap pulses_of(const RecordingContents& recording, const std::string& name,
                   const ScannerModel* model) {
    return merge_passes(passes_with_positions(recording, name, model, 0), grid_of(recording), name);
}

std::vector<PulseMap> pulses_of_passes(const RecordingContents& recording,
                                       const std::string& name) {
    return passes_with_positions(recording, name, nullptr, 0);
}

std::vector<PathTable> paths_for(const ScannerModel& model,
                                 const std::vector<std::uint8_t>& lasers) {
    std::vector<PathTable> tables;
    for (const std::uint8_t laser : lasers) {
        const auto channel =
            std::find_if(model.channels.begin(), model.channels.end(),
                         [laser](const Channel& c) { return c.laser_id == laser; });
        if (channel == model.channels.end())
            throw Error("the scanner model has no channel for laser " + std::to_string(laser) +
                        ", which the plan asks for");
        tables.push_back(make_path_table(*channel, model_hash(model)));
    }
    return tables;
}

std::string paths_note(const RecordingContents& recording, const ScannerModel& model) {
    const std::string hash = model_hash(model);
    for (const PathTable& table : recording.path_tables)
        if (!recording.pulse_maps.empty() && table.model_hash != hash)
            return "its pulses were followed along the paths of model " + table.model_hash +
                   ", not of this one (" + hash + "): where the two differ much, scan again";
    return "";
}

std::string fallback_note(const RangeImage& image) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < image.cell_count(); ++i)
        count += image.mask[i] != 0 && (image.points[i].flags & kPulseSpatialFallback) != 0;
    if (count == 0) return "";
    return std::to_string(count) + " of " + std::to_string(valid_count(image)) +
           " points are spatial peaks: no image path of 2 px or more over a pulse leads through "
           "them (near a table's axis, or outside the calibrated field)";
}

std::string directions_note(const RangeStatistics& statistics) {
    if (!statistics.directions) return "";
    const DirectionComparison& told = *statistics.directions;
    char text[280];
    std::snprintf(
        text, sizeof text,
        "two directions of the axis: %zu pulses agree; flagged as ghosts: %zu that the "
        "other direction must have seen and did not, %zu that it saw elsewhere, %zu beside "
        "them (%zu points)",
        told.agreeing, told.unseen, told.displaced, told.beside, statistics.contradicted);
    return text;
}

std::string footprint_note(const RangeStatistics& statistics) {
    const PixelFootprint& footprint = statistics.footprint;
    if (!(footprint.sigma_px > 0)) return "";
    char text[160];
    std::snprintf(text, sizeof text,
                  "points moved to the middle of their light: a pixel sees a Gaussian of %.3f px%s",
                  footprint.sigma_px,
                  footprint.sigma_of_sigma_px > 0 ? ", as the pulses show" : "");
    return text;
}

RangeResult range_of(const RecordingContents& recording, const ScannerModel& model,
                     const std::string& name, RangeOptions options) {
    const double delay_ns = model.channels.empty() ? 0 : model.channels.front().axis.delay_ns;
    std::vector<PulseMap> passes = passes_with_positions(recording, name, &model, delay_ns);
    const std::string delay_note = correct_delay(passes);
    options.axis_sigma_s = recording.axis_log.sigma_s;
    const auto directions = compare(passes, recording);
    options.directions_compared = directions.has_value();
    RangeResult result = range_from_pulses(
        merge_passes(passes, grid_of(recording), name,
                     directions ? directions->axis_sigma_s : options.axis_sigma_s),
        model, options);
    result.statistics.directions = directions;
    if (const std::string note = footprint_note(result.statistics); !note.empty())
        result.notes.push_back(note);
    if (!delay_note.empty()) result.notes.push_back(delay_note);
    if (const std::string note = directions_note(result.statistics); !note.empty())
        result.notes.push_back(note);
    if (const std::string note = fallback_note(result.image); !note.empty())
        result.notes.push_back(note);
    result.image.model_hash = model_hash(model);
    return result;
}

std::string model_hash(const ScannerModel& model) {
    std::uint64_t hash = 14695981039346656037ULL;
    for (const char c : format_scanner(model)) {
        hash ^= static_cast<std::uint8_t>(c);
        hash *= 1099511628211ULL;
    }
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

std::string describe(const RangeStatistics& statistics) {
    char text[256];
    std::snprintf(text, sizeof text,
                  "%zu points of %zu pulses (%zu outside the volume, %zu of a wrong width), median "
                  "sigma %.4f mm random, %.4f mm from calibration",
                  statistics.points, statistics.pulses, statistics.outside_volume,
                  statistics.wrong_width, statistics.median_sigma_mm,
                  statistics.median_systematic_mm);
    return text;
}

}  // namespace stria

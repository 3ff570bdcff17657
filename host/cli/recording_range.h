#pragma once
#include <string>

#include "host/link/recording_contents.h"
#include "host/scan/range_from_pulses.h"

namespace stria {

/// The sweep's pulses: those the device found, or where only frames were recorded, found here as
/// the plan says (fast where the device was set to, fast_analysis.h); spacetime on a rail or
/// turntable follows the image paths of `model`. Several maps of one grid (exposures, directions,
/// lasers) are merged (host/scan/merge_passes.h). Throws stria::Error if there is neither, if the
/// sweep was undersampled, or if paths are needed and no model is known.
/// @param name   stands for the recording in errors
/// @param model  nullptr: not known yet
PulseMap pulses_of(const RecordingContents& recording, const std::string& name,
                   const ScannerModel* model = nullptr);

/// The same, each pass (of one exposure, direction and laser) by itself.
std::vector<PulseMap> pulses_of_passes(const RecordingContents& recording, const std::string& name);

/// The image paths that a run in spacetime needs on a rail or turntable, one table for each of the
/// lasers. Throws stria::Error if the model lacks one of them or is of a swept machine.
std::vector<PathTable> paths_for(const ScannerModel& model,
                                 const std::vector<std::uint8_t>& lasers);

/// Empty, or that the device followed the paths of another model than this one.
std::string paths_note(const RecordingContents& recording, const ScannerModel& model);

/// Empty, or how many points are spatial peaks because their image paths are too short to follow.
std::string fallback_note(const RangeImage& image);

/// Empty, or what two directions of the axis say of each other's pulses.
std::string directions_note(const RangeStatistics& statistics);

/// Empty, or by which footprint points were moved to their centre of light.
std::string footprint_note(const RangeStatistics& statistics);

/// Range image of a recorded sweep, with the standard deviation of positions that its log states,
/// with the model's clock delay applied and its hash noted. Passes
/// in two directions tell what delay is left: it is noted, and corrected where it is certain. On a
/// swept machine in spacetime what one direction denies of the other is flagged and noted
/// (host/scan/compare_directions.h), unless the run broke off.
RangeResult range_of(const RecordingContents& recording, const ScannerModel& model,
                     const std::string& name, RangeOptions options = {});

/// Short hash of a model's text, 16 hexadecimal digits (FNV-1a): tells models apart, proves
/// nothing.
std::string model_hash(const ScannerModel& model);

/// What became of a sweep, one line for people.
std::string describe(const RangeStatistics& statistics);

}  // namespace stria

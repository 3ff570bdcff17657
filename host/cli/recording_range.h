#pragma once
#include <string>

#include "host/link/recording_contents.h"
#include "host/scan/range_from_pulses.h"

namespace stria {

/// The sweep's pulses: those the device found, or where only frames were recorded, found here as
/// the plan says. Several maps of one grid (exposures, directions, lasers) are joined cell by cell,
/// the strongest pulses kept. Throws stria::Error if there is neither, or the sweep was
/// undersampled.
/// @param name  stands for the recording in errors
PulseMap pulses_of(const RecordingContents& recording, const std::string& name);

/// Range image of a recorded sweep, with the model's clock delay applied and its hash noted.
RangeResult range_of(const RecordingContents& recording, const ScannerModel& model,
                     const std::string& name);

/// Short hash of a model's text, 16 hexadecimal digits (FNV-1a): tells models apart, proves
/// nothing.
std::string model_hash(const ScannerModel& model);

/// What became of a sweep, one line for people.
std::string describe(const RangeStatistics& statistics);

}  // namespace stria

#pragma once
#include <string>

#include "calib/scanner_calibration.h"
#include "host/link/recording_contents.h"

namespace stria {

/// A recording made with the laser off and on over a board, as the calibration takes it: its off
/// frames with the axis position at each, and the pulses of each pass, no clock delay applied.
/// 16-bit frames are scaled to 8. Throws stria::Error where it holds no off frame or no stripe, and
/// says which plan would give them.
/// @param name  stands for the recording in messages
CalibrationView calibration_view_of(const RecordingContents& recording, const std::string& name);

/// The design model that the device stated. Throws stria::Error if it stated none.
ScannerModel nominal_model_of(const RecordingContents& recording, const std::string& name);

}  // namespace stria

#pragma once
#include <optional>
#include <string>

#include "calib/certify.h"
#include "calib/lens_choice.h"
#include "host/cli/command.h"

namespace stria {

/// Everything a calibration of a scanner came to.
struct CalibrationOutcome {
    ScannerCalibration found;
    CrossValidation halves;
    HeldOutCheck check;
    std::optional<LensChoice> lens;  ///< where the lens model was chosen
    Certificate certificate;
    std::string replaced;  ///< path of the calibration that stood there before; empty: none
    Movement movement;     ///< against that one
    std::string written;   ///< where the model went
};

/// Lines for people, and the verb's result.
void report_calibration(const Context& context, const CalibrationOutcome& outcome);

}  // namespace stria

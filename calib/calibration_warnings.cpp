#include "calib/calibration_warnings.h"

#include <algorithm>
#include <cmath>

#include "firmware/core/angle.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

void judge_focal_length(const ScannerModel& model, std::vector<std::string>& warnings) {
    const CameraModel& camera = model.channels[0].camera;
    const double sigma_fx = std::sqrt(std::max(0.0, model.covariance(0, 0)));
    if (sigma_fx > 3e-3 * camera.fx)
        warnings.push_back("the focal length is known to " +
                           short_number(100 * sigma_fx / camera.fx, 2) +
                           " % only: add views with the board tilted");
}

void judge_scatter(const ScannerCalibration& result, std::vector<std::string>& warnings) {
    if (result.stripe_sigma_factor > 2 || result.stripe_sigma_factor < 0.5)
        warnings.push_back("stripe points scatter " + short_number(result.stripe_sigma_factor, 3) +
                           " times what their pulses claim");
    if (result.corner_sigma_px > 0.5)
        warnings.push_back("corners scatter by " + short_number(result.corner_sigma_px, 3) +
                           " px: a bent board, blur, or a lens model that does not fit");
}

}  // namespace

std::vector<std::string> calibration_warnings(const ScannerCalibration& result,
                                              const CalibrationCoverage& coverage) {
    std::vector<std::string> warnings;
    const Channel& channel = result.model.channels[0];
    for (const DegeneracyFinding& found :
         judge_coverage(coverage, channel.axis.kind, channel.camera.width, channel.camera.height))
        warnings.push_back(found.text);
    judge_focal_length(result.model, warnings);
    if (!result.converged)
        warnings.push_back("the solver stopped before it converged: look at the views' residuals");
    judge_scatter(result, warnings);
    const ValidVolume& volume = result.model.volume;
    const double diagonal = (volume.max - volume.min).norm();
    if (result.predicted.median_mm > 1e-4 * diagonal)
        warnings.push_back("the calibration leaves " + short_number(result.predicted.median_mm, 3) +
                           " mm of uncertainty at a typical point (more than 1e-4 of the volume), "
                           "most of it with " +
                           result.predicted.weakest + ": add views");
    return warnings;
}

std::string far_from_drawing(const AxisModel& solved, const AxisModel& drawn, double most_rad) {
    if (drawn.kind != MachineKind::swept) return "";
    const double turn =
        std::acos(std::clamp(solved.mirror.normal0.dot(drawn.mirror.normal0), -1.0, 1.0));
    if (turn < most_rad) return "";
    return "the mirror came out " + short_number(turn / kDegree, 3) +
           " deg from its drawing, expected less than " + short_number(most_rad / kDegree, 3) +
           ": check the drawing, or take more views";
}

std::string alike_mirrors(double margin) {
    constexpr double kApart = 2;  // half the chi-square that 2 sigma are
    if (margin >= kApart) return "";
    return "two tilts of the mirror fit almost alike (half chi-square " + short_number(margin, 2) +
           " apart), and the predicted uncertainty knows of one only: add views";
}

}  // namespace stria

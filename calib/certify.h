#pragma once
#include <string>
#include <vector>

#include "calib/cross_validation.h"
#include "calib/scanner_calibration.h"
#include "host/io/certificate.h"

namespace stria {

/// How a calibration fares on views that had no part in it.
struct HeldOutCheck {
    int views = 0;          ///< with corners and stripe
    double corner_rms = 0;  ///< in the calibration's sigmas, the board's pose fitted
    double stripe_rms = 0;
    /// Points triangulated on the board against its plane, as its corners place it: scatter about
    /// the mean of each ninth of the board, and rms of those means (their noise taken out).
    double precision_mm = 0;
    double trueness_mm = 0;
    double expected_trueness_mm = 0;  ///< by the covariance of model and pose
    /// Score test: the views' gradient by the model against what its covariance and the views'
    /// noise allow.
    double p_value = 1;
};

HeldOutCheck check_held_out(const std::vector<CornerView>& views, const Board& board,
                            const ScannerCalibration& solved);

/// Status, reasons and figures; date, temperature and hashes are the caller's. Fails: a solver that
/// did not converge; held-out corners or stripes 1.5 times as far off as the calibration's own;
/// trueness above 3 times the expected, or contradicted by the score test (p < 0.001), and above
/// 5e-5 of the volume's diagonal; an alarm of the cross-validation with halves that differ by more
/// than 1e-4 of it (halves that are expected to differ by that, being few views, judge nothing), or
/// with an error that neighbours share above 0.1 px (corners) or 5e-5 of the diagonal (stripe
/// points). Without held-out views: unchecked.
Certificate certify(const ScannerCalibration& solved, const HeldOutCheck& check,
                    const CrossValidation& halves);

/// What a new calibration changed.
struct Movement {
    bool comparable = false;
    std::string why_not;     ///< another kind of machine or lens, no covariance
    double rms_mm = 0;       ///< of the points, after the best rigid motion
    double expected_mm = 0;  ///< by both covariances
    double sigmas = 0;       ///< rms_mm / expected_mm
    std::string most;        ///< what moved most, in words
    double most_sigmas = 0;  ///< by how many of its standard deviations
};

/// @param samples  where to compare, such as pulse_samples()
Movement movement_of(const ScannerModel& before, const ScannerModel& now,
                     const std::vector<VolumeSample>& samples);

}  // namespace stria

#pragma once
#include <string>
#include <vector>

#include "calib/predicted_sigma.h"
#include "calib/scanner_calibration.h"

namespace stria {

/// Two halves of the views, each calibrated on its own, compared.
struct SplitCheck {
    std::string how;    ///< "near and far", "inner and outer"
    bool done = false;  ///< false: a half would have fewer than 4 views
    int views_a = 0, views_b = 0;
    double difference_mm = 0;  ///< rms over the volume after the best rigid motion
    double expected_mm = 0;    ///< what the halves' joint covariance predicts for it
    double chi_square = 0;
    int degrees = 0;
    double p_value = 1;
};

/// Are the residuals of neighbours on the board independent, as noise would be?
struct WhitenessCheck {
    std::size_t pairs = 0;
    double correlation = 0;  ///< mean product of neighbours' residuals over their mean square
    double z = 0;            ///< in standard deviations of that mean under independence
    double p_value = 1;      ///< one-sided: model errors make neighbours alike
    /// Standard deviation of the part that neighbours share: corners px, stripes in sigmas.
    double model_error = 0;
};

struct CrossValidation {
    std::vector<SplitCheck> splits;
    WhitenessCheck corners, stripes;  ///< neighbours on the board
    WhitenessCheck stripes_by_axis;   ///< those of a view next to each other in s
    WhitenessCheck axis_run;          ///< these, by what each sees of the axis' position
    double stripe_sigma_mm = 0;       ///< rms of the stripe points used, across the sheet
    int tests = 0;                    ///< how many of these were made
    double p_value = 1;               ///< smallest of all, times their number (Bonferroni)
    /// A model error is claimed: p_value below 0.003.
    bool alarm() const { return p_value < kClaims; }
    /// It is this test (one of `tests`) that claims it, whatever the other ones say.
    bool alarm(const SplitCheck& split) const { return tests * split.p_value < kClaims; }
    bool alarm(const WhitenessCheck& check) const { return tests * check.p_value < kClaims; }

    static constexpr double kClaims = 0.003;
};

/// Cross-validation of a finished calibration from the views it was made from. The views are split
/// by a fixed rule, twice: by the distance of the board's middle from the camera (near half, far
/// half) and by its distance from the image's centre (inner, outer): a split at random would give
/// both halves the same model error. Each half is calibrated in first order about the joint
/// solution (one Gauss-Newton step with the joint problem's rows, poses free, no priors); the
/// difference of the halves is compared with their joint covariance, H^-1 S H^-1 of each (S: how
/// the gradients scatter, errors that neighbouring corners share included; H where there are none),
/// in the directions that both see: chi-square. Besides, residuals of neighbouring corners, of
/// neighbouring stripe points of a view, and of stripe points taken at about the same position of
/// the axis must be uncorrelated (after the expectation that the fit itself leaves: minus their
/// entry of the hat matrix). Near a table's axis, neighbours on the board are far apart in angle:
/// the last sees what wobbles as the axis moves. An axis that runs unevenly moves the parts of a
/// board on a table to either side of the sheet, so the pairs are also counted by what an error of
/// the axis would show in each.
///
/// It cannot see: errors that the fit takes up without a trace (a wrong square size, axis constants
/// wrong by a common factor, anything that a rigid motion undoes); errors that change sign from one
/// corner to the next; a drift between calibration and scan; what lies where no view was. Sigmas
/// must hold. Pictures sharpened or denoised by a camera's firmware make corners alike, which
/// raises the alarm too; the halves allow for it. Source: mrcal's cross-validation (two independent
/// sets, diff against uncertainty); Moran 1950 for the correlation of neighbours.
CrossValidation cross_validate(const std::vector<CornerView>& views, const Board& board,
                               const ScannerCalibration& solved, int stripe_points_per_view = 250);

/// Evenly chosen pixels and axis positions of the views' pulses that the model triangulates.
std::vector<VolumeSample> pulse_samples(const std::vector<CornerView>& views,
                                        const ScannerModel& model, std::size_t most = 300);

}  // namespace stria

#include "calib/certify.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "calib/coach.h"
#include "calib/point_moves.h"
#include "host/core/short_number.h"

namespace stria {
namespace {

constexpr double kMostHeldOutRms = 1.5;   ///< of the calibration's own sigmas
constexpr double kMostTruenessRatio = 3;  ///< over the expected
constexpr double kLeastScoreP = 0.001;
constexpr double kTruenessMatters = 5e-5;    ///< of the volume's diagonal
constexpr double kDifferenceMatters = 1e-4;  ///< likewise, between halves
constexpr double kModelErrorMattersPx = 0.1;

void judge_check(const HeldOutCheck& check, double diagonal_mm, std::vector<std::string>& reasons) {
    if (check.corner_rms > kMostHeldOutRms)
        reasons.push_back("corners of the held-out views lie " + short_number(check.corner_rms, 3) +
                          " times as far off as the calibration's own (limit " +
                          short_number(kMostHeldOutRms, 3) + ")");
    if (check.stripe_rms > kMostHeldOutRms)
        reasons.push_back("stripe points of the held-out views lie " +
                          short_number(check.stripe_rms, 3) +
                          " times as far off as the calibration's own (limit " +
                          short_number(kMostHeldOutRms, 3) + ")");
    const bool too_far = check.trueness_mm > kMostTruenessRatio * check.expected_trueness_mm ||
                         check.p_value < kLeastScoreP;
    if (too_far && check.trueness_mm > kTruenessMatters * diagonal_mm)
        reasons.push_back("points on the held-out boards are off by " +
                          short_number(check.trueness_mm, 3) + " mm where " +
                          short_number(check.expected_trueness_mm, 3) + " mm is expected (p " +
                          short_number(check.p_value, 3) + ")");
}

void judge_halves(const CrossValidation& halves, double diagonal_mm,
                  std::vector<std::string>& reasons) {
    if (!halves.alarm()) return;
    for (const SplitCheck& split : halves.splits)
        if (split.done && halves.alarm(split) &&
            split.difference_mm > kDifferenceMatters * diagonal_mm &&
            split.expected_mm <= kDifferenceMatters * diagonal_mm)
            reasons.push_back("halves of the views (" + split.how + ") differ by " +
                              short_number(split.difference_mm, 3) + " mm where " +
                              short_number(split.expected_mm, 3) + " mm is expected (p " +
                              short_number(split.p_value, 3) +
                              "): the model does not fit the machine");
    if (halves.corners.model_error > kModelErrorMattersPx)
        reasons.push_back("corners share a model error of " +
                          short_number(halves.corners.model_error, 3) + " px (p " +
                          short_number(halves.p_value, 3) +
                          "): the lens model does not fit, or the board is bent");
    const auto judge_stripes = [&](const WhitenessCheck& stripes, const char* where,
                                   const char* meaning) {
        const double shared_mm = stripes.model_error * halves.stripe_sigma_mm;
        if (halves.alarm(stripes) && shared_mm > kTruenessMatters * diagonal_mm)
            reasons.push_back("stripe points next to each other " + std::string(where) +
                              " share an error of " + short_number(shared_mm, 3) + " mm (p " +
                              short_number(stripes.p_value, 3) + "): " + meaning);
    };
    judge_stripes(halves.stripes, "on the board",
                  "the laser's sheet is not of the shape modelled, or the board's print moves the "
                  "stripe");
    judge_stripes(halves.stripes_by_axis, "along the axis",
                  "sheet or camera wobble as the axis moves");
    judge_stripes(halves.axis_run, "along the axis, by what an error of the axis shows in them,",
                  "the axis runs unevenly, or its positions are wrong");
}

}  // namespace

Certificate certify(const ScannerCalibration& solved, const HeldOutCheck& check,
                    const CrossValidation& halves) {
    Certificate certificate;
    const double diagonal = (solved.model.volume.max - solved.model.volume.min).norm();
    if (!solved.converged) certificate.reasons.push_back("the solver did not converge");
    if (check.views > 0) judge_check(check, diagonal, certificate.reasons);
    judge_halves(halves, diagonal, certificate.reasons);
    if (!certificate.reasons.empty()) {
        certificate.status = CertificateStatus::failed;
    } else if (check.views == 0) {
        certificate.reasons.push_back("no view was held out to check the calibration");
    } else {
        certificate.status = CertificateStatus::passed;
    }
    certificate.data_hash = solved.model.provenance.data_hash;
    certificate.views = solved.views_used;
    certificate.check_views = check.views;
    certificate.precision_mm = check.precision_mm;
    certificate.trueness_mm = check.trueness_mm;
    certificate.expected_trueness_mm = check.expected_trueness_mm;
    certificate.check_p_value = check.p_value;
    certificate.cross_p_value = halves.p_value;
    certificate.model_error_px = halves.corners.model_error;
    return certificate;
}

Movement movement_of(const ScannerModel& before, const ScannerModel& now,
                     const std::vector<VolumeSample>& samples) {
    Movement movement;
    if (before.covariance.rows() == 0 || now.covariance.rows() == 0) {
        movement.why_not = "one of the calibrations states no covariance";
        return movement;
    }
    if (parameter_names(before) != parameter_names(now)) {
        movement.why_not = "the calibrations are of different machines or lens models";
        return movement;
    }
    if (samples.size() < 4) {
        movement.why_not = "no points to compare at";
        return movement;
    }
    movement.comparable = true;
    const Eigen::MatrixXd modes = covariance_modes(before.covariance + now.covariance);
    const Eigen::MatrixXd moves = point_moves(now, modes, samples);
    const Eigen::VectorXd moved = point_differences(before, now, samples);
    const double points = static_cast<double>(samples.size());
    movement.rms_mm = std::sqrt(moved.squaredNorm() / points);
    movement.expected_mm = std::sqrt(moves.squaredNorm() / points);
    movement.sigmas = movement.expected_mm > 0 ? movement.rms_mm / movement.expected_mm : 0;
    // The least change of parameters, in sigmas, that moves the points so.
    const Eigen::MatrixXd normal = moves.transpose() * moves;
    const double small = 1e-6 * normal.trace() / double(std::max<Eigen::Index>(1, normal.rows()));
    const Eigen::VectorXd step =
        (normal + small * Eigen::MatrixXd::Identity(normal.rows(), normal.cols()))
            .ldlt()
            .solve(moves.transpose() * moved);
    const auto names = parameter_names(now);
    for (Eigen::Index i = 0; i < modes.rows(); ++i) {
        const double sigma = modes.row(i).norm();
        const double sigmas = sigma > 0 ? std::abs(modes.row(i).dot(step)) / sigma : 0;
        if (sigmas <= movement.most_sigmas) continue;
        movement.most_sigmas = sigmas;
        movement.most = in_words(names[static_cast<std::size_t>(i)]);
    }
    return movement;
}

}  // namespace stria

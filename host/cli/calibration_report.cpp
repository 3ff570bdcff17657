#include "host/cli/calibration_report.h"

#include <sstream>
#include <vector>

#include "host/cli/camera_report.h"

namespace stria {
namespace {

template <typename... Parts>
std::string joined(const Parts&... parts) {
    std::ostringstream out;
    out.precision(3);
    (out << ... << parts);
    return out.str();
}

JsonResult json_of(const ScannerViewResult& view) {
    return JsonResult()
        .set("name", view.name)
        .set("rms_px", view.rms_px)
        .set("stripe_rms_sigma", view.stripe_rms)
        .set("corners_used", view.corners_used)
        .set("corners_rejected", view.corners_rejected)
        .set("stripe_points_used", view.stripe_points_used)
        .set("stripe_points_rejected", view.stripe_points_rejected)
        .set("notes", view.notes);
}

JsonResult json_of(const CrossValidation& halves) {
    std::vector<JsonResult> splits;
    for (const SplitCheck& split : halves.splits)
        if (split.done)
            splits.push_back(JsonResult()
                                 .set("how", split.how)
                                 .set("difference_mm", split.difference_mm)
                                 .set("expected_mm", split.expected_mm)
                                 .set("chi_square", split.chi_square)
                                 .set("degrees", split.degrees)
                                 .set("p_value", split.p_value));
    return JsonResult()
        .set("p_value", halves.p_value)
        .set("splits", splits)
        .set("corner_correlation", halves.corners.correlation)
        .set("corner_z", halves.corners.z)
        .set("corner_model_error_px", halves.corners.model_error)
        .set("stripe_correlation", halves.stripes.correlation)
        .set("stripe_z", halves.stripes.z)
        .set("stripe_model_error_sigma", halves.stripes.model_error)
        .set("axis_correlation", halves.stripes_by_axis.correlation)
        .set("axis_z", halves.stripes_by_axis.z)
        .set("axis_model_error_sigma", halves.stripes_by_axis.model_error)
        .set("axis_run_correlation", halves.axis_run.correlation)
        .set("axis_run_z", halves.axis_run.z)
        .set("axis_run_model_error_sigma", halves.axis_run.model_error);
}

JsonResult json_certificate(const CalibrationOutcome& outcome) {
    const Certificate& certificate = outcome.certificate;
    const ScannerCalibration& found = outcome.found;
    JsonResult json;
    json.set("status", name_of(certificate.status))
        .set("reasons", certificate.reasons)
        .set("date", certificate.date)
        .set("expires", certificate.expires)
        .set("views", certificate.views)
        .set("check_views", certificate.check_views)
        .set("precision_mm", certificate.precision_mm)
        .set("trueness_mm", certificate.trueness_mm)
        .set("expected_trueness_mm", certificate.expected_trueness_mm)
        .set("check_p_value", certificate.check_p_value)
        .set("held_out_corner_rms_sigma", outcome.check.corner_rms)
        .set("held_out_stripe_rms_sigma", outcome.check.stripe_rms)
        .set("cross_validation", json_of(outcome.halves))
        .set("converged", found.converged)
        .set("chi_square_per_dof", found.chi_square_per_dof)
        .set("corner_sigma_px", found.corner_sigma_px)
        .set("corner_noise", json_of(found.corner_noise))
        .set("stripe_sigma_factor", found.stripe_sigma_factor)
        .set("weakest", found.predicted.weakest)
        .set("data_hash", certificate.data_hash)
        .set("check_hash", certificate.check_hash);
    if (certificate.temperature_c) json.set("temperature_c", *certificate.temperature_c);
    return json;
}

void say_certificate(const Context& context, const CalibrationOutcome& outcome) {
    const Certificate& certificate = outcome.certificate;
    if (certificate.check_views > 0)
        context.say(joined("check on ", certificate.check_views, " views held out: precision ",
                           certificate.precision_mm, " mm, trueness ", certificate.trueness_mm,
                           " mm (expected ", certificate.expected_trueness_mm, " mm), p ",
                           certificate.check_p_value));
    for (const SplitCheck& split : outcome.halves.splits)
        if (split.done)
            context.say(joined("halves (", split.how, ") differ by ", split.difference_mm,
                               " mm, expected ", split.expected_mm, " mm, p ", split.p_value));
    say_noise(context, outcome.found.corner_noise,
              "a flat board or --board-warp, --lens rational8 for a wide lens, pictures that the "
              "camera has not "
              "sharpened");
    context.say(joined("residuals of neighbours: corners ", outcome.halves.corners.z,
                       " sigma alike (model error ", outcome.halves.corners.model_error,
                       " px), stripes ", outcome.halves.stripes.z, " sigma alike on the board, ",
                       outcome.halves.stripes_by_axis.z, " along the axis, ",
                       outcome.halves.axis_run.z, " as its errors would show"));
    context.say(std::string("certificate: ") + name_of(certificate.status));
    for (const std::string& reason : certificate.reasons) context.say("  " + reason);
}

void say_movement(const Context& context, const CalibrationOutcome& outcome) {
    if (outcome.replaced.empty()) return;
    const Movement& moved = outcome.movement;
    if (!moved.comparable) {
        context.say("not compared with " + outcome.replaced + ": " + moved.why_not);
        return;
    }
    context.say(joined("against ", outcome.replaced, ": points moved by ", moved.rms_mm,
                       " mm rms = ", moved.sigmas, " sigma",
                       moved.most.empty()
                           ? ""
                           : joined("; most: ", moved.most, ", ", moved.most_sigmas, " sigma")));
}

}  // namespace

void report_calibration(const Context& context, const CalibrationOutcome& outcome) {
    const ScannerCalibration& found = outcome.found;
    std::vector<JsonResult> views, rejected;
    for (const ScannerViewResult& view : found.views) {
        if (!view.rejected.empty()) {
            rejected.push_back(JsonResult().set("file", view.name).set("reason", view.rejected));
            context.say("not used: " + view.name + ": " + view.rejected);
        }
        for (const std::string& note : view.notes) context.say(view.name + ": " + note);
        views.push_back(json_of(view));
    }
    const Eigen::Vector3d size = found.model.volume.max - found.model.volume.min;
    context.say(joined(outcome.written, ": corners ", found.rms_px, " px rms over ",
                       found.views_used, " views, predicted point sigma ",
                       found.predicted.median_mm, " mm (95 %: ", found.predicted.p95_mm, ") over ",
                       size.x(), " x ", size.y(), " x ", size.z(), " mm"));
    const Eigen::Vector2d &warp = found.board_warp_mm, &warp_sigma = found.board_warp_sigma_mm;
    if (!warp_sigma.isZero())
        context.say(joined("the board bulges by ", warp.x(), " +- ", warp_sigma.x(),
                           " mm along its rows, ", warp.y(), " +- ", warp_sigma.y(),
                           " mm along its columns"));
    for (const std::string& warning : found.warnings) context.say("warning: " + warning);
    say_certificate(context, outcome);
    say_movement(context, outcome);
    JsonResult result;
    result.set("rms_px", found.rms_px)
        .set("predicted_sigma_mm", JsonResult()
                                       .set("median", found.predicted.median_mm)
                                       .set("p95", found.predicted.p95_mm))
        .set("volume_mm3", size.prod())
        .set("warnings", found.warnings)
        .set("views_used", found.views_used)
        .set("views_rejected", rejected)
        .set("views", views)
        .set("written", outcome.written)
        .set("certificate", json_certificate(outcome));
    if (!warp_sigma.isZero())
        result.set("board_warp_mm", std::vector<double>{warp.x(), warp.y()})
            .set("board_warp_sigma_mm", std::vector<double>{warp_sigma.x(), warp_sigma.y()});
    if (outcome.lens) result.set("lens_trials", json_of(*outcome.lens));
    if (!outcome.replaced.empty() && outcome.movement.comparable)
        result.set("moved", JsonResult()
                                .set("rms_mm", outcome.movement.rms_mm)
                                .set("expected_mm", outcome.movement.expected_mm)
                                .set("sigmas", outcome.movement.sigmas)
                                .set("most", outcome.movement.most)
                                .set("most_sigmas", outcome.movement.most_sigmas));
    context.finish(result);
}

}  // namespace stria

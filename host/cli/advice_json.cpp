#include "host/cli/advice_report.h"

namespace stria {
namespace {

JsonResult method_json(const MethodSigma& sigma) {
    return JsonResult()
        .set("position_sigma", sigma.position)
        .set("sigma_x_mm", sigma.x_mm)
        .set("sigma_z_noise_mm", sigma.noise_z_mm)
        .set("sigma_z_speckle_mm", sigma.speckle_z_mm)
        .set("sigma_z_mm", sigma.z_mm)
        .set("dominated_by", sigma.speckle_dominates() ? "speckle" : "noise");
}

JsonResult footprint_json(const DepthAdvice& at) {
    return JsonResult()
        .set("pixel_mm", at.pixel_mm)
        .set("diffraction_sigma_mm", at.footprint.diffraction_mm)
        .set("defocus_sigma_mm", at.footprint.defocus_mm)
        .set("aberration_sigma_mm", at.footprint.aberration_mm)
        .set("pixel_sigma_mm", at.footprint.pixel_mm)
        .set("sigma_p_mm", at.footprint.sigma_mm());
}

JsonResult depth_json(const char* name, const DepthAdvice& at) {
    return JsonResult()
        .set("name", name)
        .set("depth_mm", at.depth_mm)
        .set("triangulation_rad", at.crossing.triangulation_rad)
        .set("footprint", footprint_json(at))
        .set("sigma_b_mm", at.sigma_b_mm)
        .set("sigma_p_over_sigma_b", at.footprint.sigma_mm() / at.sigma_b_mm)
        .set("incidence_rad", at.incidence_rad)
        .set("peak_e", at.peak_e)
        .set("snr", at.snr)
        .set("saturated", at.saturated)
        .set("frames_per_sigma", at.frames_per_sigma)
        .set("greatest_step", at.greatest_step)
        .set("spacetime", method_json(at.spacetime))
        .set("spatial", method_json(at.spatial))
        .set("speckle", JsonResult()
                            .set("size_mm", at.speckle_mm)
                            .set("contrast", at.contrast)
                            .set("wavefront_mm", at.wavefront_mm)
                            .set("effective_distance_mm", at.effective_distance_mm))
        .set("edge", JsonResult()
                         .set("spatial_mm", at.edge.spatial_mm)
                         .set("spacetime_mm", at.edge.spacetime_mm)
                         .set("ratio", at.edge.ratio));
}

std::vector<JsonResult> waists_json(const Advice& advice) {
    std::vector<JsonResult> waists;
    for (const WaistChoice& w : advice.waists)
        waists.push_back(JsonResult()
                             .set("name", w.name)
                             .set("waist_sigma_mm", w.waist_sigma_mm)
                             .set("sigma_b_mm", w.sigma_b_mm)
                             .set("wavefront_mm", w.wavefront_mm)
                             .set("effective_distance_mm", w.effective_distance_mm)
                             .set("speckle_x_mm", w.speckle_x_mm));
    return waists;
}

JsonResult occlusion_json(const Occlusion& seen, double hole_width_mm) {
    return JsonResult()
        .set("hemisphere_share", seen.hemisphere_share)
        .set("steepest_wall_rad", seen.steepest_wall_rad)
        .set("hole_depth_per_width", seen.hole_depth_per_width)
        .set("best_hole_depth_per_width", seen.best_hole_depth_per_width)
        .set("hole_width_mm", hole_width_mm)
        .set("hole_depth_mm", seen.hole_depth_per_width * hole_width_mm);
}

}  // namespace

JsonResult advice_json(const ReportedAdvice& reported) {
    const Advice& advice = reported.advice;
    JsonResult result;
    result.set("kind", name_of(advice.kind))
        .set("mode", advice.mode == StripeMode::spacetime ? "spacetime" : "spatial")
        .set("baseline_mm", advice.baseline_mm)
        .set("triangulation_rad", advice.middle.crossing.triangulation_rad)
        .set("focal_mm", advice.lens.focal_mm)
        .set("field_mm", std::vector<double>{advice.field_width_mm, advice.field_height_mm})
        .set("fan_needed_rad", advice.fan_needed_rad)
        .set("waist_sigma_mm", reported.scanner.channel.sheet.waist_sigma_mm)
        .set("exposure_us", advice.exposure_us)
        .set("greatest_step", advice.greatest_step)
        .set("advised_step", advice.advised_step)
        .set("step", advice.step)
        .set("from", advice.range.from)
        .set("to", advice.range.to)
        .set("frames", advice.frames)
        .set("seconds", advice.seconds)
        .set("sigma_z_mm", advice.worst_z_mm())
        .set("depths", std::vector<JsonResult>{depth_json("near", advice.near),
                                               depth_json("middle", advice.middle),
                                               depth_json("far", advice.far)})
        .set("worst", depth_json("worst", advice.worst)
                          .set("point_mm", Eigen::VectorXd(advice.worst.crossing.point_in_camera)))
        .set("waists", waists_json(advice))
        .set("occlusion", occlusion_json(advice.occlusion, reported.scanner.surface.hole_width_mm))
        .set("warnings", advice.warnings);
    if (reported.wanted_sigma_z_mm) {
        result.set("wanted_sigma_z_mm", *reported.wanted_sigma_z_mm)
            .set("wanted_sigma_z_met", advice.worst_z_mm() <= *reported.wanted_sigma_z_mm * 1.0001)
            .set("best_sigma_z_mm", reported.best_sigma_z_mm);
        if (reported.baseline_for_sigma_mm)
            result.set("baseline_for_sigma_mm", *reported.baseline_for_sigma_mm);
    }
    std::vector<JsonResult> changes;
    for (const Change& change : reported.changes)
        changes.push_back(JsonResult()
                              .set("what", change.what)
                              .set("sigma_z_mm", change.z_mm)
                              .set("gain", change.gain)
                              .set("sigma_p_over_sigma_b", change.edge_ratio)
                              .set("seconds", change.seconds));
    return result.set("changes", changes);
}

}  // namespace stria

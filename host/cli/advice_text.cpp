#include <cmath>
#include <cstdio>

#include "firmware/core/angle.h"
#include "host/cli/advice_report.h"

namespace stria {
namespace {

template <typename... Values>
std::string line(const char* format, Values... values) {
    char text[400];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}

/// A length as people say it.
std::string length(double mm) {
    if (!std::isfinite(mm)) return "infinite";
    const double size = std::abs(mm);
    if (size < 1) return line("%.3g um", 1000 * mm);
    return size < 10000 ? line("%.4g mm", mm) : line("%.3g m", mm / 1000);
}

std::string position(MachineKind kind, double s) {
    if (kind == MachineKind::rail) return line("%.4g mm", s);
    return line("%.4g rad (%.3g deg)", s, s / kDegree);
}

using Lines = std::vector<std::string>;

void add_scanner(const ReportedAdvice& reported, Lines& out) {
    const Advice& a = reported.advice;
    const LaserSheet& sheet = reported.scanner.channel.sheet;
    const CameraModel& camera = reported.scanner.channel.camera;
    out.push_back(line("THE SCANNER  (%s)", name_of(a.kind)));
    out.push_back(line("  field %s x %s at %s, depth %s to %s", length(a.field_width_mm).c_str(),
                       length(a.field_height_mm).c_str(), length(a.middle.depth_mm).c_str(),
                       length(a.near.depth_mm).c_str(), length(a.far.depth_mm).c_str()));
    out.push_back(
        line("  camera %d x %d, %.3g um pixels, focal length %.3g mm at f/%.3g, one pixel "
             "is %s on the part",
             camera.width, camera.height, a.lens.pixel_um, a.lens.focal_mm, a.lens.f_number,
             length(a.middle.pixel_mm).c_str()));
    out.push_back(line("  baseline %s, triangulation angle %.3g deg (%.3g near, %.3g far)",
                       length(a.baseline_mm).c_str(), a.middle.crossing.triangulation_rad / kDegree,
                       a.near.crossing.triangulation_rad / kDegree,
                       a.far.crossing.triangulation_rad / kDegree));
    out.push_back(
        line("  laser %.4g nm, %.3g mW, waist sigma %s, fan %.3g deg (the field needs "
             "%.3g deg)",
             sheet.wavelength_nm, reported.scanner.power_mw, length(sheet.waist_sigma_mm).c_str(),
             sheet.fan_rad / kDegree, a.fan_needed_rad / kDegree));
}

void add_sweep(const ReportedAdvice& reported, Lines& out) {
    const Advice& a = reported.advice;
    out.push_back("");
    out.push_back("THE SWEEP");
    out.push_back(line("  step %s, %.2g frames a stripe's width; the greatest is %s",
                       position(a.kind, a.step).c_str(), a.greatest_step / a.step,
                       position(a.kind, a.greatest_step).c_str()));
    out.push_back(
        line("  exposure %.4g us, %.0f frames, %.3g s", a.exposure_us, a.frames, a.seconds));
}

void add_depths(const ReportedAdvice& reported, Lines& out) {
    const Advice& a = reported.advice;
    const bool spacetime = a.mode == StripeMode::spacetime;
    out.push_back("");
    out.push_back(line("WHAT TO EXPECT  (one standard deviation; the device scans %s)",
                       spacetime ? "over time" : "in space"));
    out.push_back("                         near         middle            far");
    const auto row = [&](const char* name, auto value) {
        out.push_back(line("  %-13s %14s %14s %14s", name, value(a.near).c_str(),
                           value(a.middle).c_str(), value(a.far).c_str()));
    };
    using D = const DepthAdvice&;
    row("depth", [](D d) { return length(d.depth_mm); });
    row("sigma z", [&](D d) { return length(a.method(d).z_mm); });
    row("  noise", [&](D d) { return length(a.method(d).noise_z_mm); });
    row("  speckle", [&](D d) { return length(a.method(d).speckle_z_mm); });
    row("sigma x", [&](D d) { return length(a.method(d).x_mm); });
    row(spacetime ? "(in space) z" : "(over time) z",
        [&](D d) { return length((spacetime ? d.spatial : d.spacetime).z_mm); });
    row("SNR", [](D d) { return line("%.3g", d.snr); });
    row("sigma_b", [](D d) { return length(d.sigma_b_mm); });
    row("sigma_p", [](D d) { return length(d.footprint.sigma_mm()); });
    row("  diffraction", [](D d) { return length(d.footprint.diffraction_mm); });
    row("  defocus", [](D d) { return length(d.footprint.defocus_mm); });
    row("edge in space", [](D d) { return length(d.edge.spatial_mm); });
    row("edge in time", [](D d) { return length(d.edge.spacetime_mm); });
    const Eigen::Vector3d& p = a.worst.crossing.point_in_camera;
    out.push_back(
        line("  Worst in the field: sigma z %s at (%.0f, %.0f, %.0f) mm from the camera, "
             "where the SNR is %.3g.",
             length(a.method(a.worst).z_mm).c_str(), p.x(), p.y(), p.z(), a.worst.snr));
    const MethodSigma& middle = a.method(a.middle);
    out.push_back(line("  In the middle %s dominates: %s against %s.",
                       middle.speckle_dominates() ? "speckle" : "camera noise",
                       length(std::max(middle.speckle_z_mm, middle.noise_z_mm)).c_str(),
                       length(std::min(middle.speckle_z_mm, middle.noise_z_mm)).c_str()));
}

void add_edges(const ReportedAdvice& reported, Lines& out) {
    const DepthAdvice& m = reported.advice.middle;
    const double ratio = m.footprint.sigma_mm() / m.sigma_b_mm;
    out.push_back("");
    out.push_back("EDGES OF THE PAINT");
    out.push_back(
        line("  A %.3g:1 edge shifts a stripe's centre by up to %s in depth; followed "
             "over time by %s,",
             reported.scanner.surface.reflectance_ratio, length(m.edge.spatial_mm).c_str(),
             length(m.edge.spacetime_mm).c_str()));
    out.push_back(
        line("  %.0f %% less: what is left is the camera's footprint over the stripe's "
             "width, sigma_p/sigma_b = %.2g.",
             100 * (1 - m.edge.ratio), ratio));
    if (ratio > 0.3)
        out.push_back("  Above 0.3 little is won: a wider stripe, or a sharper camera.");
}

void add_waist(const ReportedAdvice& reported, Lines& out) {
    const Advice& a = reported.advice;
    const DepthAdvice& m = a.middle;
    out.push_back("");
    out.push_back("THE WAIST OF THE BEAM");
    if (a.kind == MachineKind::swept)
        out.push_back(
            line("  The light turns about the mirror, %s away. Speckle stays frozen while "
                 "the beam crosses a point if",
                 length(m.crossing.pivot_mm).c_str()));
    else
        out.push_back("  Speckle stays frozen while the beam crosses a point if");
    out.push_back(a.kind == MachineKind::swept
                      ? "  its wavefront is centred there too (waist at the mirror); else it boils "
                        "and adds to the error:"
                      : "  its wavefront is flat (waist on the object); else it boils and adds to "
                        "the error:");
    for (const WaistChoice& w : a.waists)
        out.push_back(
            line("  %-14s waist %-9s stripe %-9s wavefront %-9s D_eff %-9s speckle %s "
                 "across",
                 w.name.c_str(), length(w.waist_sigma_mm).c_str(), length(w.sigma_b_mm).c_str(),
                 length(w.wavefront_mm).c_str(), length(w.effective_distance_mm).c_str(),
                 length(w.speckle_x_mm).c_str()));
}

void add_occlusion(const ReportedAdvice& reported, Lines& out) {
    const Occlusion& o = reported.advice.occlusion;
    const double width_mm = reported.scanner.surface.hole_width_mm;
    out.push_back("");
    out.push_back("WHAT CAMERA AND LASER BOTH SEE");
    out.push_back(
        line("  %.0f %% of a half sphere; walls that lean up to %.0f deg away from the laser",
             100 * o.hemisphere_share, o.steepest_wall_rad / kDegree));
    out.push_back(
        line("  a slot %s wide along the stripe down to %s, or %s if it faces half-way between "
             "camera and laser",
             length(width_mm).c_str(), length(o.hole_depth_per_width * width_mm).c_str(),
             length(o.best_hole_depth_per_width * width_mm).c_str()));
}

void add_wanted(const ReportedAdvice& reported, Lines& out) {
    if (!reported.wanted_sigma_z_mm) return;
    out.push_back("");
    if (reported.baseline_for_sigma_mm)
        out.push_back(line("A sigma z of %s over the whole depth takes a baseline of %s.",
                           length(*reported.wanted_sigma_z_mm).c_str(),
                           length(*reported.baseline_for_sigma_mm).c_str()));
    else
        out.push_back(line("A sigma z of %s cannot be had: even at 60 deg it is %s. See below.",
                           length(*reported.wanted_sigma_z_mm).c_str(),
                           length(reported.best_sigma_z_mm).c_str()));
}

void add_changes(const ReportedAdvice& reported, Lines& out) {
    out.push_back("");
    out.push_back("WHAT TO CHANGE FIRST  (sigma z at the worst depth, now " +
                  length(reported.advice.worst_z_mm()) + ")");
    bool any = false;
    for (const Change& change : reported.changes) {
        if (change.gain <= 0) continue;
        any = true;
        out.push_back(line("  %s: %s, %.0f %% less; sigma_p/sigma_b %.2g, %.3g s",
                           change.what.c_str(), length(change.z_mm).c_str(), 100 * change.gain,
                           change.edge_ratio, change.seconds));
    }
    if (!any) out.push_back("  none of the usual changes helps");
}

}  // namespace

std::vector<std::string> advice_text(const ReportedAdvice& reported) {
    Lines out;
    add_scanner(reported, out);
    add_sweep(reported, out);
    add_depths(reported, out);
    add_edges(reported, out);
    add_waist(reported, out);
    add_occlusion(reported, out);
    add_wanted(reported, out);
    add_changes(reported, out);
    if (!reported.advice.warnings.empty()) out.push_back("");
    for (const std::string& warning : reported.advice.warnings)
        out.push_back("WARNING: " + warning);
    return out;
}

}  // namespace stria

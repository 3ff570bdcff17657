#include "host/advise/advise.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "firmware/core/angle.h"
#include "host/advise/depth_advice.h"
#include "host/advise/speckle.h"
#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kExposedShare = 0.8;  ///< of full scale, for the brightest surface
constexpr double kFramesPerSigma = 2;  ///< accuracy.md A.1: 2 to 3 cost nothing but time
constexpr double kDimSnr = 10;

template <typename... Numbers>
std::string line(const char* format, Numbers... numbers) {
    char text[400];
    std::snprintf(text, sizeof text, format, numbers...);
    return text;
}

const char* unit_of(MachineKind kind) { return kind == MachineKind::rail ? "mm" : "rad"; }

/// What brings the brightest surface facing the camera to its share of full scale.
double advised_exposure_us(const AdvisedScanner& scanner, const Advice& advice) {
    const SensorSpec& sensor = scanner.sensor;
    const double room_dn =
        (full_scale_dn(sensor) - sensor.black_dn) *
        (kExposedShare - scanner.surface.ambient_level * scanner.surface.brightest_albedo);
    double most = 0;  // electrons a second
    for (const DepthAdvice* at : {&advice.near, &advice.middle, &advice.far})
        most =
            std::max(most, peak_rate(scanner, advice.lens, *at, scanner.surface.brightest_albedo));
    const double wanted_us = std::max(0.0, room_dn) * gain_e_per_dn(sensor) / most * 1e6;
    return std::clamp(wanted_us, 1e-3, sensor.frame_period_us);
}

using Places = std::vector<DepthAdvice>;

/// The field's corners, edges and middle at the three depths; on rail and table the row's place
/// across the image is the sheet's.
Places places_of(const AdvisedScanner& scanner, const Advice& advice) {
    Places places;
    for (const double depth_mm : {scanner.near_mm, scanner.middle_mm, scanner.far_mm})
        for (const double v : {-1.0, 0.0, 1.0})
            for (const double u : {-1.0, 0.0, 1.0}) {
                if (u != 0 && advice.kind != MachineKind::swept) continue;
                places.push_back(look_at(scanner, advice.lens, depth_mm, {u, v}));
            }
    return places;
}

[[noreturn]] void refuse_step(const AdvisedScanner& scanner, const Advice& advice,
                              const DepthAdvice& narrowest) {
    const char* unit = unit_of(advice.kind);
    const double step_mm = *scanner.step * narrowest.crossing.mm_per_s;
    throw Error(line(
        "step = %.4g %s moves the stripe by %.4g mm from frame to frame, above its "
        "width of %.4g mm (one standard deviation) at x = %.4g mm and a depth of %.4g mm: the "
        "sweep would be undersampled and miss what lies between. Take %.4g %s (two frames a "
        "width), at most %.4g %s",
        *scanner.step, unit, step_mm, narrowest.sigma_b_mm, narrowest.crossing.point_in_camera.x(),
        narrowest.depth_mm, advice.advised_step, unit, advice.greatest_step, unit));
}

void choose_step(const AdvisedScanner& scanner, const Places& places, Advice& advice) {
    const auto narrowest = std::min_element(
        places.begin(), places.end(),
        [](const auto& a, const auto& b) { return a.greatest_step < b.greatest_step; });
    advice.greatest_step = narrowest->greatest_step;
    if (!std::isfinite(advice.greatest_step))
        throw Error("the axis does not move the sheet over the surface at the stated depths");
    advice.advised_step = advice.greatest_step / kFramesPerSigma;
    if (scanner.step && *scanner.step > advice.greatest_step)
        refuse_step(scanner, advice, *narrowest);
    advice.step = scanner.step.value_or(advice.advised_step);
}

void find_worst(const AdvisedScanner& scanner, Places places, Advice& advice) {
    double worst_mm = -1;
    for (DepthAdvice& at : places) {
        add_sigmas(scanner, advice.lens, advice.step, advice.exposure_us, at);
        if (!(advice.method(at).z_mm > worst_mm)) continue;
        worst_mm = advice.method(at).z_mm;
        advice.worst = at;
    }
}

void choose_range(const AdvisedScanner& scanner, Advice& advice) {
    const auto range = axis_range(scanner.channel, scanner.near_mm, scanner.far_mm);
    if (!range)
        throw Error("the sheet does not reach every corner of the image at depths of " +
                    line("%.4g to %.4g mm", scanner.near_mm, scanner.far_mm) +
                    ": expected a nearer depth range or a smaller field");
    advice.range = *range;
    if (!scanner.travel) return;
    const char* unit = unit_of(advice.kind);
    if (range->from < scanner.travel->from || range->to > scanner.travel->to)
        advice.warnings.push_back(
            line("the whole field asks for s = %.4g to %.4g %s, but the axis "
                 "travels from %.4g to %.4g %s only",
                 range->from, range->to, unit, scanner.travel->from, scanner.travel->to, unit));
    advice.range.from = std::max(range->from, scanner.travel->from);
    advice.range.to = std::min(range->to, scanner.travel->to);
    if (!(advice.range.from < advice.range.to))
        throw Error(
            line("nothing of the field at the stated depths lies within the axis's travel "
                 "of %.4g to %.4g %s",
                 scanner.travel->from, scanner.travel->to, unit));
}

/// Devices analyse swept machines over time, the others in space.
StripeMode mode_of(MachineKind kind) {
    return kind == MachineKind::swept ? StripeMode::spacetime : StripeMode::spatial;
}

WaistChoice waist_choice(const AdvisedScanner& scanner, const Advice& advice, std::string name,
                         double waist_sigma_mm, double z_mm) {
    const Crossing& crossing = advice.middle.crossing;
    const GaussianBeam beam{waist_sigma_mm, crossing.sheet.wavelength_nm, scanner.m_squared};
    WaistChoice choice;
    choice.name = std::move(name);
    choice.waist_sigma_mm = waist_sigma_mm;
    choice.sigma_b_mm = sigma_at_mm(beam, z_mm);
    choice.wavefront_mm = wavefront_radius_mm(beam, z_mm);
    choice.effective_distance_mm = effective_distance_at(scanner, crossing, choice.wavefront_mm);
    choice.speckle_x_mm = temporal_speckle_mm(advice.middle.contrast, crossing.sheet.wavelength_nm,
                                              sin_aperture(advice.lens, advice.middle.depth_mm),
                                              choice.sigma_b_mm, choice.effective_distance_mm);
    return choice;
}

/// The stated beam, and beams as wide in the middle with the waist at the mirror and on the object.
void compare_waists(const AdvisedScanner& scanner, Advice& advice) {
    const DepthAdvice& middle = advice.middle;
    const LaserSheet& sheet = scanner.channel.sheet;
    advice.waists.push_back(waist_choice(scanner, advice, "as stated", sheet.waist_sigma_mm,
                                         from_waist_mm(scanner, middle.crossing)));
    if (advice.kind == MachineKind::swept) {
        const double d = middle.crossing.pivot_mm;
        const double waist =
            waist_for_mm(middle.sigma_b_mm, d, sheet.wavelength_nm, scanner.m_squared);
        advice.waists.push_back(waist_choice(scanner, advice, "at the mirror", waist, d));
    }
    advice.waists.push_back(waist_choice(scanner, advice, "on the object", middle.sigma_b_mm, 0));
}

/// Depths as people list them, where `holds`.
template <typename Holds>
std::string depths_where(const Advice& advice, Holds holds) {
    std::string depths;
    for (const DepthAdvice* at : {&advice.near, &advice.middle, &advice.far})
        if (holds(*at)) depths += (depths.empty() ? "" : ", ") + line("%.4g", at->depth_mm);
    return depths;
}

void warn_of_light(const AdvisedScanner& scanner, Advice& advice) {
    const std::string bright =
        depths_where(advice, [](const DepthAdvice& at) { return at.saturated; });
    if (!bright.empty())
        advice.warnings.push_back(
            line("the brightest surface (albedo %.3g) saturates at depths of %s mm: an exposure "
                 "of %.4g us fits it",
                 scanner.surface.brightest_albedo, bright.c_str(),
                 advised_exposure_us(scanner, advice)));
    const std::string dim = depths_where(
        advice, [](const DepthAdvice& at) { return !at.saturated && at.snr < kDimSnr; });
    if (!dim.empty())
        advice.warnings.push_back(
            line("the signal is less than %.0f times its noise at depths of %s mm: more power, a "
                 "longer exposure or a more open lens come first",
                 kDimSnr, dim.c_str()));
}

void warn(const AdvisedScanner& scanner, Advice& advice) {
    std::vector<std::string>& out = advice.warnings;
    const std::string outside =
        depths_where(advice, [](const DepthAdvice& at) { return !at.crossing.in_image; });
    if (!outside.empty())
        out.push_back(
            line("the stripe lies outside the image at depths of %s mm", outside.c_str()));
    warn_of_light(scanner, advice);
    const double fan = scanner.channel.sheet.fan_rad;
    if (fan < advice.fan_needed_rad)
        out.push_back(
            line("the laser's fan of %.3g deg does not light the whole field: %.3g deg "
                 "are needed",
                 fan / kDegree, advice.fan_needed_rad / kDegree));
    const double angle = advice.middle.crossing.triangulation_rad;
    if (angle < 10 * kDegree || angle > 60 * kDegree)
        out.push_back(
            line("a triangulation angle of %.3g deg is unusual: below 10 deg depth is "
                 "vague, above 60 deg little is seen by both camera and laser",
                 angle / kDegree));
}

}  // namespace

double Advice::worst_z_mm() const {
    return std::max({method(near).z_mm, method(middle).z_mm, method(far).z_mm});
}

Advice advise(const AdvisedScanner& scanner) {
    if (const std::string why = validate(scanner); !why.empty()) throw std::invalid_argument(why);
    const CameraModel& camera = scanner.channel.camera;
    Advice advice;
    advice.kind = scanner.channel.axis.kind;
    advice.mode = mode_of(advice.kind);
    advice.lens =
        lens_of(camera.fx, scanner.sensor.pixel_um, scanner.sensor.f_number, scanner.focus_mm);
    advice.lens.aberration_px = scanner.sensor.aberration_px;
    advice.near = look_at(scanner, advice.lens, scanner.near_mm);
    advice.middle = look_at(scanner, advice.lens, scanner.middle_mm);
    advice.far = look_at(scanner, advice.lens, scanner.far_mm);
    advice.field_width_mm = camera.width * advice.middle.pixel_mm;
    advice.field_height_mm = camera.height * advice.middle.depth_mm / camera.fy;
    const Eigen::Vector3d laser = advice.kind == MachineKind::swept
                                      ? scanner.channel.axis.mirror.point
                                      : scanner.channel.sheet.apex;
    advice.baseline_mm = laser.head<2>().norm();
    advice.fan_needed_rad = fan_needed_rad(scanner.channel, scanner.near_mm, scanner.far_mm);
    const Places places = places_of(scanner, advice);
    choose_step(scanner, places, advice);
    advice.exposure_us = scanner.sensor.exposure_us.value_or(advised_exposure_us(scanner, advice));
    for (DepthAdvice* at : {&advice.near, &advice.middle, &advice.far})
        add_sigmas(scanner, advice.lens, advice.step, advice.exposure_us, *at);
    find_worst(scanner, places, advice);
    choose_range(scanner, advice);
    advice.frames = std::ceil((advice.range.to - advice.range.from) / advice.step);
    advice.seconds =
        advice.frames * std::max(scanner.sensor.frame_period_us, advice.exposure_us) * 1e-6;
    compare_waists(scanner, advice);
    advice.occlusion = occlusion_of(advice.middle.crossing.triangulation_rad);
    warn(scanner, advice);
    return advice;
}

}  // namespace stria

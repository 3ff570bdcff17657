#include "host/advise/depth_advice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/advise/light.h"
#include "host/advise/pulse_bound.h"
#include "host/advise/speckle.h"
#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Standard deviation across the sheet of what a pixel sees of the beam: beam and footprint (the
/// pixel's box included) as the pulse over time shows them.
double pulse_sigma_mm(const DepthAdvice& at) {
    return std::hypot(at.sigma_b_mm,
                      at.footprint.sigma_mm() * std::cos(at.crossing.triangulation_rad));
}

double background_dn(const AdvisedScanner& scanner, double albedo) {
    const double full = full_scale_dn(scanner.sensor) - scanner.sensor.black_dn;
    return scanner.sensor.black_dn + scanner.surface.ambient_level * albedo * full;
}

SampledPulse pulse_over_time(const AdvisedScanner& scanner, const DepthAdvice& at, double rate,
                             double step, double exposure_us) {
    SampledPulse pulse;
    pulse.amplitude_dn = rate * exposure_us * 1e-6 / gain_e_per_dn(scanner.sensor);
    pulse.width = pulse_sigma_mm(at) / (at.crossing.mm_per_s * step);
    pulse.half_aperture = 0.5 * exposure_us / std::max(scanner.sensor.frame_period_us, exposure_us);
    pulse.background_dn = background_dn(scanner, scanner.surface.albedo);
    pulse.full_scale_dn = full_scale_dn(scanner.sensor);
    return pulse;
}

/// The stripe across an image row: the beam on the surface and the lens's blur, the pixel as the
/// aperture, and the way of the sheet during the exposure.
SampledPulse stripe_over_pixels(const AdvisedScanner& scanner, const DepthAdvice& at,
                                double rate_unblurred, double step, double exposure_us) {
    const double angle = at.crossing.triangulation_rad;
    const double share = exposure_us / std::max(scanner.sensor.frame_period_us, exposure_us);
    const double way_mm = at.crossing.mm_per_s * step * share;
    const double across_mm = std::hypot(at.sigma_b_mm, way_mm / std::sqrt(12.0));
    const double in_image_mm = std::hypot(across_mm / std::cos(angle), at.footprint.lens_mm());
    SampledPulse pulse;
    pulse.amplitude_dn = rate_unblurred * exposure_us * 1e-6 / gain_e_per_dn(scanner.sensor) *
                         at.sigma_b_mm / std::cos(angle) / in_image_mm;
    pulse.width = in_image_mm / at.pixel_mm;
    pulse.background_dn = background_dn(scanner, scanner.surface.albedo);
    pulse.full_scale_dn = full_scale_dn(scanner.sensor);
    return pulse;
}

void combine(MethodSigma& sigma) { sigma.z_mm = std::hypot(sigma.noise_z_mm, sigma.speckle_z_mm); }

double unblurred_rate(const AdvisedScanner& scanner, const Lens& lens, const DepthAdvice& at,
                      double albedo) {
    const LaserSheet& sheet = at.crossing.sheet;
    if (std::abs(fan_angle(sheet, at.crossing.point_in_camera)) > sheet.fan_rad / 2) return 0;
    return line_electrons_per_s({.power_mw = scanner.power_mw,
                                 .fan_rad = sheet.fan_rad,
                                 .range_mm = at.crossing.laser_mm,
                                 .sigma_b_mm = at.sigma_b_mm,
                                 .wavelength_nm = sheet.wavelength_nm,
                                 .incidence_rad = at.incidence_rad,
                                 .albedo = albedo},
                                scanner.sensor, lens);
}

}  // namespace

GaussianBeam beam_of(const AdvisedScanner& scanner) {
    const LaserSheet& sheet = scanner.channel.sheet;
    return {sheet.waist_sigma_mm, sheet.wavelength_nm, scanner.m_squared};
}

double from_waist_mm(const AdvisedScanner& scanner, const Crossing& crossing) {
    return crossing.laser_mm - scanner.channel.sheet.waist_at_mm;
}

double effective_distance_at(const AdvisedScanner& scanner, const Crossing& crossing,
                             double wavefront_mm) {
    if (scanner.channel.axis.kind == MachineKind::turntable)
        return effective_distance_mm(-crossing.pivot_mm, std::abs(wavefront_mm));
    return effective_distance_mm(crossing.pivot_mm, wavefront_mm);
}

DepthAdvice look_at(const AdvisedScanner& scanner, const Lens& lens, double depth_mm,
                    const Eigen::Vector2d& field) {
    const auto crossing = crossing_at_depth(scanner.channel, depth_mm, field);
    if (!crossing)
        throw Error("the sheet does not pass the camera's field at a depth of " +
                    std::to_string(depth_mm) + " mm: expected a depth that the laser reaches");
    DepthAdvice at;
    at.depth_mm = depth_mm;
    at.crossing = *crossing;
    at.pixel_mm = pixel_on_object_mm(lens, depth_mm);
    const double wavelength_nm = crossing->sheet.wavelength_nm;
    at.footprint = footprint_at(lens, wavelength_nm, depth_mm);
    if (scanner.sensor.perfect_lens) at.footprint = {.pixel_mm = at.footprint.pixel_mm};
    const GaussianBeam beam = beam_of(scanner);
    const double z_mm = from_waist_mm(scanner, *crossing);
    at.sigma_b_mm = sigma_at_mm(beam, z_mm);
    at.incidence_rad = scanner.surface.incidence_rad.value_or(crossing->triangulation_rad);
    at.greatest_step = crossing->mm_per_s > 0 ? at.sigma_b_mm / crossing->mm_per_s : kInfinite;
    const double sin_u = sin_aperture(lens, depth_mm);
    at.speckle_mm = speckle_size_mm(wavelength_nm, sin_u);
    at.contrast =
        contrast_after_pixel(scanner.surface.speckle_contrast, at.pixel_mm, at.speckle_mm);
    at.wavefront_mm = wavefront_radius_mm(beam, z_mm);
    at.effective_distance_mm = effective_distance_at(scanner, *crossing, at.wavefront_mm);
    at.edge = edge_error(scanner.surface.reflectance_ratio, at.footprint.sigma_mm(), at.sigma_b_mm,
                         crossing->triangulation_rad);
    return at;
}

double peak_rate(const AdvisedScanner& scanner, const Lens& lens, const DepthAdvice& at,
                 double albedo) {
    return unblurred_rate(scanner, lens, at, albedo) * at.sigma_b_mm / pulse_sigma_mm(at);
}

void add_sigmas(const AdvisedScanner& scanner, const Lens& lens, double step, double exposure_us,
                DepthAdvice& at) {
    const SensorNoise noise = noise_of(scanner.sensor);
    const double angle = at.crossing.triangulation_rad, sin_u = sin_aperture(lens, at.depth_mm);
    const double cos_axis = at.crossing.point_in_camera.z() / at.crossing.point_in_camera.norm();
    const double wavelength_nm = at.crossing.sheet.wavelength_nm;

    const SampledPulse pulse = pulse_over_time(
        scanner, at, peak_rate(scanner, lens, at, scanner.surface.albedo), step, exposure_us);
    at.peak_e = sample_of(pulse, 0) * noise.gain_e_per_dn;
    at.peak_dn = sample_of(pulse, 0) + pulse.background_dn;
    at.saturated = sample_of(pulse, 0) * scanner.surface.brightest_albedo / scanner.surface.albedo +
                       background_dn(scanner, scanner.surface.brightest_albedo) >
                   pulse.full_scale_dn;
    at.snr = peak_snr(pulse, noise);
    at.frames_per_sigma = at.greatest_step / step;

    MethodSigma& time = at.spacetime;
    time.position = position_bound(pulse, noise);
    const double along_axis_mm = time.position * step * at.crossing.along_ray_mm_per_s * cos_axis;
    const double axis_z_mm = scanner.axis_sigma * std::abs(at.crossing.shift_per_s.z());
    time.noise_z_mm = std::hypot(along_axis_mm, axis_z_mm);
    time.x_mm = along_axis_mm * std::tan(angle);
    time.speckle_z_mm = temporal_speckle_mm(at.contrast, wavelength_nm, sin_u, at.sigma_b_mm,
                                            at.effective_distance_mm) /
                        std::sin(angle);
    combine(time);

    MethodSigma& space = at.spatial;
    const SampledPulse stripe = stripe_over_pixels(
        scanner, at, unblurred_rate(scanner, lens, at, scanner.surface.albedo), step, exposure_us);
    space.position = position_bound(stripe, noise);
    space.x_mm = space.position * at.pixel_mm;
    space.noise_z_mm = std::hypot(space.x_mm / std::tan(angle), axis_z_mm);
    space.speckle_z_mm =
        spatial_speckle_mm(at.contrast, at.speckle_mm, at.sigma_b_mm) / std::sin(angle);
    combine(space);
}

}  // namespace stria

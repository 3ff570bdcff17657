#include "host/advise/scanner.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

namespace stria {
namespace {

SensorSpec sensor_of(double pixel_um, double full_well_e, double read_noise_e, int bits,
                     double efficiency, double frame_period_us) {
    SensorSpec sensor;
    sensor.pixel_um = pixel_um;
    sensor.full_well_e = full_well_e;
    sensor.read_noise_e = read_noise_e;
    sensor.bits = bits;
    sensor.quantum_efficiency = efficiency;
    sensor.frame_period_us = frame_period_us;
    return sensor;
}

bool within(double value, double low, double high) { return value >= low && value <= high; }
bool above_to(double value, double low, double high) { return value > low && value <= high; }

}  // namespace

double gain_e_per_dn(const SensorSpec& sensor) {
    if (sensor.gain_e_per_dn) return *sensor.gain_e_per_dn;
    return sensor.full_well_e / ((1 << sensor.bits) - 1 - sensor.black_dn);
}

double full_scale_dn(const SensorSpec& sensor) {
    return std::min<double>((1 << sensor.bits) - 1,
                            sensor.black_dn + sensor.full_well_e / gain_e_per_dn(sensor));
}

SensorNoise noise_of(const SensorSpec& sensor) {
    return {.gain_e_per_dn = gain_e_per_dn(sensor),
            .read_noise_e = sensor.read_noise_e,
            .black_dn = sensor.black_dn};
}

const std::vector<NamedCamera>& named_cameras() {
    static const std::vector<NamedCamera> cameras = {
        {"imx296",
         "1.6 Mpx global shutter, 60 frames/s (Raspberry Pi Global Shutter Camera); full well and "
         "noise as usual for Sony's 3.45 um pixels",
         1456, 1088, sensor_of(3.45, 10500, 2.5, 10, 0.5, 16700)},
        {"imx174",
         "2.3 Mpx global shutter, 5.86 um; EMVA 1288: full well 32691 e-, dark noise 6.83 e-", 1920,
         1200, sensor_of(5.86, 32691, 6.83, 12, 0.6, 6100)},
        {"imx477",
         "12 Mpx rolling shutter (Raspberry Pi HQ); measured: full well 8180 e-, read noise 3 e-",
         4056, 3040, sensor_of(1.55, 8180, 3, 12, 0.6, 100000)},
    };
    return cameras;
}

const NamedCamera& named_camera(const std::string& name) {
    std::string known;
    for (const NamedCamera& camera : named_cameras()) {
        if (camera.name == name) return camera;
        known += (known.empty() ? "" : ", ") + camera.name;
    }
    throw std::invalid_argument("camera '" + name + "' is not known: expected one of " + known);
}

std::string wrong_value(const std::string& name, double value, const std::string& bound) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return name + " = " + text + ": expected " + bound;
}

std::string validate(const SensorSpec& s) {
    if (!within(s.pixel_um, 0.5, 50)) return wrong_value("pixel_um", s.pixel_um, "0.5 to 50");
    if (!within(s.f_number, 0.7, 64)) return wrong_value("f_number", s.f_number, "0.7 to 64");
    if (!within(s.full_well_e, 100, 1e7))
        return wrong_value("full_well_e", s.full_well_e, "100 to 10000000");
    if (!within(s.read_noise_e, 0, s.full_well_e / 10))
        return wrong_value("read_noise_e", s.read_noise_e, "0 to a tenth of the full well");
    if (!within(s.bits, 8, 16)) return wrong_value("bits", s.bits, "8 to 16");
    if (s.gain_e_per_dn && !above_to(*s.gain_e_per_dn, 0, s.full_well_e))
        return wrong_value("gain_e_per_dn", *s.gain_e_per_dn, "above 0, at most the full well");
    if (!within(s.black_dn, 0, (1 << s.bits) / 2.0))
        return wrong_value("black_dn", s.black_dn, "0 to half the converter's range");
    if (!above_to(s.quantum_efficiency, 0, 1))
        return wrong_value("quantum_efficiency", s.quantum_efficiency, "0 to 1, 0 excluded");
    if (!within(s.aberration_px, 0, 20))
        return wrong_value("aberration_px", s.aberration_px, "0 to 20");
    if (!above_to(s.frame_period_us, 0, 1e7))
        return wrong_value("frame_period_us", s.frame_period_us, "above 0, at most 10 s");
    if (s.exposure_us && !above_to(*s.exposure_us, 0, s.frame_period_us))
        return wrong_value(
            "exposure_us", *s.exposure_us,
            "above 0, at most the frame period of " + std::to_string(s.frame_period_us) + " us");
    return "";
}

std::string validate(const SurfaceSpec& s) {
    if (!above_to(s.albedo, 0, 1)) return wrong_value("albedo", s.albedo, "0 to 1, 0 excluded");
    if (!within(s.brightest_albedo, s.albedo, 1))
        return wrong_value("brightest_albedo", s.brightest_albedo, "the albedo to 1");
    if (s.incidence_rad && !(*s.incidence_rad >= 0 && *s.incidence_rad < std::numbers::pi / 2))
        return wrong_value("incidence_rad", *s.incidence_rad,
                           "0 to below 90 deg: light along a surface does not light it");
    if (!within(s.reflectance_ratio, 1, 1000))
        return wrong_value("reflectance_ratio", s.reflectance_ratio, "1 to 1000");
    if (!above_to(s.hole_width_mm, 0, 1e5))
        return wrong_value("hole_width_mm", s.hole_width_mm, "above 0");
    if (!within(s.speckle_contrast, 0, 1))
        return wrong_value("speckle_contrast", s.speckle_contrast, "0 to 1");
    if (!within(s.ambient_level, 0, 1))
        return wrong_value("ambient_level", s.ambient_level, "0 to 1");
    return "";
}

std::string validate(const AdvisedScanner& scanner) {
    ScannerModel model;
    model.channels.push_back(scanner.channel);
    if (std::string why = validate(model); !why.empty()) return why;
    if (std::string why = validate(scanner.sensor); !why.empty()) return why;
    if (std::string why = validate(scanner.surface); !why.empty()) return why;
    if (!above_to(scanner.power_mw, 0, 1e5))
        return wrong_value("power_mw", scanner.power_mw, "above 0, at most 100 W");
    if (!within(scanner.m_squared, 1, 100))
        return wrong_value("m_squared", scanner.m_squared, "1 to 100: no beam is better than 1");
    if (!(std::isfinite(scanner.far_mm) && scanner.near_mm > 0 &&
          scanner.near_mm <= scanner.middle_mm && scanner.middle_mm <= scanner.far_mm))
        return wrong_value("near_mm", scanner.near_mm, "above 0, before middle_mm and far_mm");
    if (!(std::isfinite(scanner.focus_mm) && scanner.focus_mm > 0))
        return wrong_value("focus_mm", scanner.focus_mm, "above 0");
    if (scanner.step && !(std::isfinite(*scanner.step) && *scanner.step > 0))
        return wrong_value("step", *scanner.step, "above 0");
    if (!(std::isfinite(scanner.axis_sigma) && scanner.axis_sigma >= 0))
        return wrong_value("axis_sigma", scanner.axis_sigma, "0 or more");
    if (scanner.travel && !(scanner.travel->from < scanner.travel->to))
        return wrong_value("travel.to", scanner.travel->to, "above travel.from");
    return "";
}

}  // namespace stria

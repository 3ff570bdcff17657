#include "sim/scanner_preset.h"

#include <cmath>

namespace stria {
namespace {

/// Charge and noise from a data sheet's decibels, the full well at the converter's top.
void set_charge(SceneSensor& sensor, double snr_max_db, double dynamic_range_db) {
    sensor.full_well_e = std::pow(10, snr_max_db / 10);
    sensor.read_noise_e = sensor.full_well_e / std::pow(10, dynamic_range_db / 20);
    sensor.gain_e_per_dn = sensor.full_well_e / ((1 << sensor.bits) - 1 - sensor.black_dn);
}

ScannerPreset pi_global_shutter() {
    ScannerPreset preset;
    preset.sensor.bits = 10;
    preset.sensor.black_dn = 60;  // Sony's usual offset
    preset.sensor.pixel_um = 3.45;
    preset.sensor.min_frame_period_us = 1e6 / 60;
    set_charge(preset.sensor, 40.2, 71.4);
    return preset;
}

ScannerPreset industrial() {
    ScannerPreset preset;
    preset.sensor.bits = 12;
    preset.sensor.black_dn = 240;
    preset.sensor.pixel_um = 3.45;
    preset.sensor.min_frame_period_us = 1e6 / 226.5;
    preset.wavelength_nm = 450;
    set_charge(preset.sensor, 40.2, 71.4);
    return preset;
}

ScannerPreset rolling_webcam() {
    ScannerPreset preset;
    preset.sensor.bits = 8;
    preset.sensor.pixel_um = 3.75;
    preset.sensor.row_time_us = 1650 / 74.25;
    preset.sensor.min_frame_period_us = 1e6 / 45.6;
    set_charge(preset.sensor, 37.7, 63.4);
    return preset;
}

}  // namespace

std::optional<ScannerPreset> scanner_preset(const std::string& name) {
    if (name == "pi-global-shutter") return pi_global_shutter();
    if (name == "industrial-1.6mp") return industrial();
    if (name == "rolling-webcam") return rolling_webcam();
    return std::nullopt;
}

std::string scanner_preset_names() {
    return "pi-global-shutter, industrial-1.6mp or rolling-webcam";
}

}  // namespace stria

#pragma once
#include <optional>
#include <string>

#include "sim/scene.h"

namespace stria {

/// What a scene that names a preset starts from; its own keys win.
struct ScannerPreset {
    SceneSensor sensor;
    double wavelength_nm = 650;
};

/// Presets, by sensors whose figures their makers publish (EMVA 1288: full well = 10^(SNRmax / 10),
/// read noise = full well / 10^(DNR / 20), SNRmax and DNR in dB):
///   "pi-global-shutter"  Raspberry Pi Global Shutter Camera (Sony IMX296, 3.45 um, 10 bits,
///                        1456 x 1088 at 60 frames/s) with a red line, 650 nm; charge and noise of
///                        the IMX273, whose pixel has the same size
///   "industrial-1.6mp"   Sony IMX273 (3.45 um, 12 bits, 1456 x 1088 at 226.5 frames/s, SNRmax
///                        40.2 dB, DNR 71.4 dB: Balluff's documentation of the BVS CA-SF 0016Z)
///                        with a blue line, 450 nm
///   "rolling-webcam"     Aptina MT9M034 as 8-bit camera (3.75 um, 1280 x 960 at 45.6 frames/s,
///                        rows of 1650 clocks of 74.25 MHz, SNRmax 37.7 dB, DNR 63.4 dB: the
///                        same maker's documentation of the mvBlueFOX3-1012d), red line
/// Quantum efficiency and f_number stay what a scene has without a preset.
/// Empty if there is none of that name.
std::optional<ScannerPreset> scanner_preset(const std::string& name);
/// The names, as a message lists them.
std::string scanner_preset_names();

}  // namespace stria

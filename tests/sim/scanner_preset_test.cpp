#include "sim/scanner_preset.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/core/errors.h"
#include "host/io/whole_file.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

/// The swept example without its [sensor] table and wavelength, begun by `head`.
std::string example_with(const std::string& head) {
    std::string text = read_whole_file(example_scene("swept.toml"));
    const std::size_t sensor = text.find("[sensor]"), laser = text.find("[laser]");
    text.erase(sensor, laser - sensor);
    const std::size_t wavelength = text.find("wavelength_nm");
    if (wavelength != std::string::npos)
        text.erase(wavelength, text.find('\n', wavelength) - wavelength);
    return head + "\n" + text;
}

Scene preset_scene(const std::string& name) {
    return parse_scene(example_with("preset = \"" + name + "\""), "scene.toml", "");
}

TEST(ScannerPreset, HasTheFiguresOfItsDataSheet) {
    const SceneSensor fast = preset_scene("industrial-1.6mp").sensor;
    EXPECT_NEAR(10 * std::log10(fast.full_well_e), 40.2, 1e-9);  // SNRmax: shot noise alone
    EXPECT_NEAR(20 * std::log10(fast.full_well_e / fast.read_noise_e), 71.4, 1e-9);
    EXPECT_NEAR(1e6 / fast.min_frame_period_us, 226.5, 1e-9);
    EXPECT_EQ(preset_scene("industrial-1.6mp").channel.sheet.wavelength_nm, 450);
    EXPECT_EQ(preset_scene("pi-global-shutter").channel.sheet.wavelength_nm, 650);
    const SceneSensor slow = preset_scene("rolling-webcam").sensor;
    EXPECT_GT(slow.row_time_us, 0);
    // 960 rows and the 27 blanked ones of the maker's formula are the frame period.
    EXPECT_NEAR(slow.row_time_us * 987, slow.min_frame_period_us, 0.001 * slow.min_frame_period_us);
}

TEST(ScannerPreset, EveryOneIsASceneThatFillsItsConverter) {
    for (const char* name : {"pi-global-shutter", "industrial-1.6mp", "rolling-webcam"}) {
        Scene scene = preset_scene(name);
        EXPECT_EQ(validate(scene), "") << name;
        EXPECT_NEAR(full_scale_e(scene.sensor), scene.sensor.full_well_e, 1e-6) << name;
        // Written out in numbers, it is the same scene.
        const std::string text = format_scene(scene);
        EXPECT_EQ(format_scene(parse_scene(text, name, "")), text);
        EXPECT_EQ(text.find("preset"), std::string::npos);
        scene.sensor.noise = true;
        SimulatedScanner scanner(scene, 1);
        EXPECT_EQ(record_still(scanner, 0, 1).bits, scene.sensor.bits);
    }
}

TEST(ScannerPreset, TheScenesOwnKeysWin) {
    std::string text =
        example_with("preset = \"industrial-1.6mp\"") + "\n[sensor]\nread_noise_e = 6\n";
    const Scene scene = parse_scene(text, "scene.toml", "");
    EXPECT_EQ(scene.sensor.read_noise_e, 6);
    EXPECT_EQ(scene.sensor.bits, 12);
}

TEST(ScannerPreset, AnUnknownNameListsTheKnownOnes) {
    try {
        (void)preset_scene("webcam");
        FAIL();
    } catch (const FileError& error) {
        EXPECT_NE(std::string(error.what()).find("rolling-webcam"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("found webcam"), std::string::npos);
    }
}

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "host/cli/quantity.h"
#include "host/cli/recording_range.h"
#include "host/cli/run.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "sim/nominal_model.h"
#include "sim/scene.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/sim/plate_scene.h"

namespace stria {
namespace {

struct Outcome {
    int code = 0;
    std::string out, err;
};

Outcome advise(const std::vector<std::string>& more) {
    std::vector<const char*> argv = {"stria", "advise"};
    for (const std::string& argument : more) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Outcome run;
    run.code = run_program(static_cast<int>(argv.size()), argv.data());
    std::fflush(stdout);
    run.out = testing::internal::GetCapturedStdout();
    run.err = testing::internal::GetCapturedStderr();
    return run;
}

bool has(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

TEST(AdviseVerb, DefaultsGiveAWholeAdvice) {
    const Outcome run = advise({});
    EXPECT_EQ(run.code, 0) << run.err;
    for (const char* part : {"THE SCANNER", "THE SWEEP", "WHAT TO EXPECT", "EDGES OF THE PAINT",
                             "THE WAIST OF THE BEAM", "BOTH SEE", "WHAT TO CHANGE FIRST"})
        EXPECT_TRUE(has(run.out, part)) << part;
}

TEST(AdviseVerb, JsonKeepsItsKeys) {
    const Outcome run = advise({"--json", "--sigma-z", "100um"});
    EXPECT_EQ(run.code, 0) << run.err;
    for (const char* key : {"kind",
                            "mode",
                            "baseline_mm",
                            "triangulation_rad",
                            "focal_mm",
                            "field_mm",
                            "exposure_us",
                            "greatest_step",
                            "advised_step",
                            "step",
                            "from",
                            "to",
                            "frames",
                            "seconds",
                            "sigma_z_mm",
                            "depths",
                            "footprint",
                            "sigma_p_mm",
                            "sigma_b_mm",
                            "snr",
                            "spacetime",
                            "spatial",
                            "dominated_by",
                            "edge",
                            "waists",
                            "effective_distance_mm",
                            "occlusion",
                            "hemisphere_share",
                            "warnings",
                            "changes",
                            "wanted_sigma_z_met",
                            "baseline_for_sigma_mm"})
        EXPECT_TRUE(has(run.out, "\"" + std::string(key) + "\"")) << key;
    EXPECT_EQ(run.out.front(), '{');
}

TEST(AdviseVerb, WritesAPlanThatReadsBack) {
    const TemporaryFolder folder;
    ASSERT_EQ(advise({"--plan", folder / "plan.toml", "--quiet"}).code, 0);
    const ScanPlan plan = read_plan(folder / "plan.toml");
    EXPECT_EQ(plan.mode, StripeMode::spacetime);
    EXPECT_GT(plan.step, 0);
    EXPECT_EQ(plan.exposures_us.size(), 1U);
    EXPECT_EQ(advise({"--plan", folder / "plan.toml"}).code, 1) << "it exists";
    ASSERT_EQ(advise({"--kind", "rail", "--plan", folder / "rail.toml", "--quiet"}).code, 0);
    EXPECT_EQ(read_plan(folder / "rail.toml").mode, StripeMode::spatial);
}

TEST(AdviseVerb, ItsPlanScansTheScene) {
    const TemporaryFolder folder;
    Scene scene = built_in_scene();
    test::crop_to_middle(scene.channel.camera, 80, 60);
    scene.objects = {scene.objects[1]};  // the plate behind, 450 mm away
    write_whole_file(folder / "scene.toml", format_scene(scene));
    ASSERT_EQ(advise({"--scene", folder / "scene.toml", "--distance", "450", "--depth", "40",
                      "--plan", folder / "plan.toml"})
                  .code,
              0);
    const char* const simulate[] = {"stria", "simulate", "--quiet", nullptr,
                                    "--out", nullptr,    "--plan",  nullptr};
    std::vector<const char*> argv(std::begin(simulate), std::end(simulate));
    const std::string scene_file = folder / "scene.toml", out = folder / "out",
                      plan_file = folder / "plan.toml";
    argv[3] = scene_file.c_str();
    argv[5] = out.c_str();
    argv[7] = plan_file.c_str();
    ASSERT_EQ(run_program(static_cast<int>(argv.size()), argv.data()), 0);
    const PulseMap pulses = pulses_of(load_recording(folder / "out/recording.stria"), "scan");
    EXPECT_FALSE(pulses.undersampled);
    EXPECT_GT(pulses.pulses.size(), 0.9 * 80 * 60);
}

TEST(AdviseVerb, RefusesAStepAboveTheWidth) {
    const TemporaryFolder folder;
    const Outcome run = advise({"--step", "2mrad", "--plan", folder / "plan.toml"});
    EXPECT_EQ(run.code, 1);
    EXPECT_TRUE(has(run.err, "step = 0.002 rad")) << run.err;
    EXPECT_TRUE(has(run.err, "width")) << run.err;
    EXPECT_TRUE(has(run.err, "Take")) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "plan.toml"));
}

TEST(AdviseVerb, AdvisesForASceneAndForAModel) {
    const TemporaryFolder folder;
    const Scene scene = built_in_scene();
    write_whole_file(folder / "scene.toml", format_scene(scene));
    write_scanner(folder / "scanner.toml", truth_model(scene));
    const Outcome of_scene = advise({"--scene", folder / "scene.toml"});
    EXPECT_EQ(of_scene.code, 0) << of_scene.err;
    EXPECT_TRUE(has(of_scene.out, "camera 800 x 640")) << of_scene.out;
    const Outcome of_model = advise({"--model", folder / "scanner.toml", "--pixel-pitch", "5um",
                                     "--distance", "400", "--depth", "4cm"});
    EXPECT_EQ(of_model.code, 0) << of_model.err;
    EXPECT_TRUE(has(of_model.out, "depth 380 mm to 420 mm")) << of_model.out;
    const Outcome no_such = advise({"--model", folder / "scanner.toml", "--channel", "1"});
    EXPECT_EQ(no_such.code, 1);
    EXPECT_TRUE(has(no_such.err, "channels 0 to 0")) << no_such.err;
}

TEST(AdviseVerb, RefusesWhatTheSceneFixes) {
    const TemporaryFolder folder;
    write_whole_file(folder / "scene.toml", format_scene(built_in_scene()));
    for (const char* option :
         {"--width", "--baseline", "--waist", "--kind", "--pixels", "--camera"}) {
        const Outcome run = advise({"--scene", folder / "scene.toml", option, "100"});
        EXPECT_EQ(run.code, 1) << option;
        EXPECT_TRUE(has(run.err, option) && has(run.err, "fixed by")) << run.err;
    }
    EXPECT_EQ(advise({"--scene", folder / "scene.toml", "--model", "x"}).code, 1);
}

TEST(AdviseVerb, NamesBadNumbers) {
    const struct {
        std::vector<std::string> arguments;
        const char* message;
    } cases[] = {
        {{"--distance", "nan"}, "--distance 'nan': expected a finite number"},
        {{"--distance", "0"}, "distance_mm = 0: expected above 0"},
        {{"--distance", "-3"}, "distance_mm = -3"},
        {{"--width", "10kg"}, "--width '10kg': expected a finite number, its unit one of mm"},
        {{"--depth", "900"}, "depth_mm = 900"},
        {{"--fan", "0"}, "fan_rad"},
        {{"--channel", "1"}, "--channel: expected with --model only"},
        {{"--pixels", "100"}, "--pixels '100': expected WIDTHxHEIGHT"},
        {{"--camera", "box"}, "camera 'box' is not known"},
        {{"--kind", "drone"}, "--kind 'drone'"},
        {{"--bits", "10.5"}, "--bits"},
        {{"--exposure", "1s"}, "exposure_us"},
        {{"--incidence", "90deg"}, "incidence_rad"},
        {{"--step", "1mm"}, "--step '1mm': expected an angle"},
        {{"--kind", "rail", "--step", "1deg"}, "--step '1deg': expected a length"},
    };
    for (const auto& c : cases) {
        const Outcome run = advise(c.arguments);
        EXPECT_EQ(run.code, 1) << c.arguments[0];
        EXPECT_TRUE(has(run.err, c.message)) << run.err;
    }
}

TEST(Quantity, ReadsUnits) {
    EXPECT_NEAR(parse_quantity("o", "0.3mm", Quantity::length_mm), 0.3, 1e-15);
    EXPECT_NEAR(parse_quantity("o", "2 in", Quantity::length_mm), 50.8, 1e-12);
    EXPECT_NEAR(parse_quantity("o", "2", Quantity::length_mm, 25.4), 50.8, 1e-12);
    EXPECT_NEAR(parse_quantity("o", "3.45", Quantity::pitch_um), 3.45, 1e-12);
    EXPECT_NEAR(parse_quantity("o", "0.00345mm", Quantity::pitch_um), 3.45, 1e-9);
    EXPECT_NEAR(parse_quantity("o", "0.65um", Quantity::wavelength_nm), 650, 1e-9);
    EXPECT_NEAR(parse_quantity("o", "180", Quantity::angle_rad), M_PI, 1e-12);
    EXPECT_NEAR(parse_quantity("o", "5ms", Quantity::time_us), 5000, 1e-9);
    EXPECT_NEAR(parse_quantity("o", "0.02W", Quantity::power_mw), 20, 1e-12);
    EXPECT_NEAR(parse_quantity("o", "0.001", Quantity::position), 0.001, 1e-18);
    EXPECT_NEAR(parse_quantity("o", "1mrad", Quantity::position), 0.001, 1e-18);
    for (const char* text : {"", "inf", "nan", "mm", "1 mm mm", "1e999", "--1"})
        EXPECT_THROW(parse_quantity("o", text, Quantity::length_mm), std::invalid_argument) << text;
}

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "firmware/protocol/codec.h"
#include "host/cli/recording_range.h"
#include "host/cli/run.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "host/local/local_scanner.h"
#include "sim/scene.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/support/machine_scenes.h"

/// Spacetime along image paths measured on the device, against the host's analysis of the recorded
/// frames of the same sweep.
namespace stria {
namespace {

class OnTheDevice : public testing::TestWithParam<MachineKind> {
  protected:
    OnTheDevice() {
        scene = test_support::machine_scenes(GetParam(), 3).sphere_scene;
        CameraModel& camera = scene.channel.camera;  // a band about the middle is enough
        constexpr int kRows = 96;
        camera.cy += 0.5 * (kRows - camera.height);
        camera.height = kRows;
        model.channels = {scene.channel};
        const bool rail = GetParam() == MachineKind::rail;
        plan.mode = StripeMode::spacetime;
        plan.record = RecordWhat::both;
        plan.off_frames = 2;
        plan.from = rail ? -4 : -0.05;
        plan.to = -plan.from;
        plan.step = rail ? 0.25 : 0.006;
    }
    Scene scene;
    ScannerModel model;
    ScanPlan plan;
    TemporaryFolder folder;
};

Bytes bytes_of(const PulseMap& map) { return encode(PulseBand{map, 0, map.height}); }

TEST_P(OnTheDevice, PulsesAreByteForByteThoseOfTheRecordedFrames) {
    LocalScanner scanner(scene);
    scanner.set_paths(paths_for(model, {0}));
    RunOptions options;
    options.recording_path = folder / "scan.stria";
    const RecordingContents live = scanner.run(plan, options);
    ASSERT_TRUE(live.end);
    ASSERT_TRUE(live.end->complete) << live.end->reason;
    EXPECT_EQ(paths_note(live, model), "");
    ASSERT_EQ(live.pulse_maps.size(), 1U);
    EXPECT_GT(live.pulse_maps[0].pulses.size(), 500U);

    RecordingContents frames_alone = live;
    frames_alone.pulse_maps.clear();
    const PulseMap on_host = pulses_of(frames_alone, "frames", &model);
    EXPECT_TRUE(bytes_of(on_host) == bytes_of(live.pulse_maps[0]));

    const RecordingContents replayed = load_recording(options.recording_path);
    const auto range = [&](const RecordingContents& contents) {
        return format_range_image(range_of(contents, model, "scan").image);
    };
    EXPECT_TRUE(range(replayed) == range(live));
    ScannerModel other = model;
    other.channels[0].camera.fx *= 1.001;
    EXPECT_NE(paths_note(replayed, other).find("scan again"), std::string::npos);
}

TEST(FallbackNote, CountsSpatialPeaksAmongThePoints) {
    RangeImage image = make_range_image(3, 1);
    image.mask = {1, 1, 0};
    EXPECT_EQ(fallback_note(image), "");
    image.points[1].flags = image.points[2].flags = kPulseSpatialFallback;
    EXPECT_EQ(fallback_note(image).find("1 of 2 points are spatial peaks"), 0U);
}

// There and back: the passes are two maps, of one grid but for a frame at an end, and neighbours of
// the joined grid are neighbours on the part.
TEST_P(OnTheDevice, BothDirectionsJoin) {
    plan.both_directions = true;
    LocalScanner scanner(scene);
    scanner.set_paths(paths_for(model, {0}));
    RecordingContents run = scanner.run(plan);
    ASSERT_EQ(run.pulse_maps.size(), 2U);
    const PulseMap joined = pulses_of(run, "run", &model);
    EXPECT_EQ(joined.pulses.size(),
              run.pulse_maps[0].pulses.size() + run.pulse_maps[1].pulses.size());
    for (int y = 0; y < joined.height; ++y)
        for (int x = 0; x < joined.width; ++x)
            for (const Pulse& pulse : joined.cell(x, y))
                ASSERT_NEAR(pulse.s, plan.from + (x + 0.5) * plan.step, 3.5 * plan.step)
                    << x;  // a seed leads up to 2.5 widths and a step away
    run.pulse_maps.clear();
    EXPECT_TRUE(bytes_of(pulses_of(run, "frames", &model)) == bytes_of(joined));
}

int stria(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    return run_program(static_cast<int>(argv.size()), argv.data());
}

TEST_P(OnTheDevice, ScanSendsThePathsOfItsProject) {
    write_whole_file(folder / "scene.toml", format_scene(scene));
    plan.record = RecordWhat::pulses;
    write_whole_file(folder / "plan.toml", format_plan(plan));
    const std::vector<std::string> scan = {"scan",   "sim:" + (folder / "scene.toml"),
                                           "--out",  folder / "part",
                                           "--plan", folder / "plan.toml",
                                           "--quiet"};
    testing::internal::CaptureStderr();
    EXPECT_EQ(stria(scan), 1);  // no calibration yet
    const std::string told = testing::internal::GetCapturedStderr();
    EXPECT_NE(told.find("scanner.toml"), std::string::npos) << told;

    write_scanner(folder / "scanner.toml", model);
    std::vector<std::string> with_model = scan;
    with_model.insert(with_model.end(), {"--model", folder / "scanner.toml"});
    ASSERT_EQ(stria(with_model), 0);
    ASSERT_EQ(stria(scan), 0);  // the project has its scanner.toml now
    const RecordingContents kept = load_recording(folder / "part/scans/0002/recording.stria");
    EXPECT_EQ(kept.path_tables, paths_for(read_scanner(folder / "part/scanner.toml"), {0}));
    ASSERT_EQ(kept.pulse_maps.size(), 1U);
    EXPECT_EQ(kept.pulse_maps[0].mode, StripeMode::spacetime);
    EXPECT_GT(valid_count(read_range_image(folder / "part/scans/0002/range.ply")), 500U);
}

INSTANTIATE_TEST_SUITE_P(Kinds, OnTheDevice,
                         testing::Values(MachineKind::rail, MachineKind::turntable),
                         [](const auto& kind) { return std::string(name_of(kind.param)); });

}  // namespace
}  // namespace stria

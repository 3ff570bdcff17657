#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "host/cli/run.h"
#include "host/io/image_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "host/link/recording_contents.h"
#include "sim/scene.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

int simulate(const std::vector<std::string>& more) {
    std::vector<const char*> argv = {"stria", "simulate", "--quiet"};
    for (const std::string& argument : more) argv.push_back(argument.c_str());
    return run_program(static_cast<int>(argv.size()), argv.data());
}

/// The built-in scanner with a small camera, and a plan of 21 frames.
void write_inputs(const TemporaryFolder& folder) {
    Scene scene = built_in_scene();
    CameraModel& camera = scene.channel.camera;
    camera.width = 100;
    camera.height = 80;
    camera.fx = camera.fy = 144;
    camera.cx = 50;
    camera.cy = 40;
    scene.channel.sheet.waist_sigma_mm = 1;
    write_whole_file(folder / "scene.toml", format_scene(scene));
    write_whole_file(
        folder / "plan.toml",
        "mode = \"spacetime\"\nfrom = -0.01\nto = 0.01\nstep = 0.001\noff_frames = 2\n");
}

std::vector<double> numbers_of(const std::string& text) {
    std::istringstream in(text);
    std::vector<double> numbers;
    for (double s = 0; in >> s;) numbers.push_back(s);
    return numbers;
}

TEST(Simulate, WritesImagesTimesRecordingAndTruth) {
    const TemporaryFolder folder;
    write_inputs(folder);
    ASSERT_EQ(simulate({folder / "scene.toml", "--out", folder / "out", "--plan",
                        folder / "plan.toml", "--frames"}),
              0);
    const std::vector<double> times = numbers_of(read_whole_file(folder / "out/times.txt"));
    ASSERT_GE(times.size(), 19U);
    std::size_t images = 0, off = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "out")) {
        const std::string name = entry.path().filename().string();
        images += name.rfind("frame_", 0) == 0;
        off += name.rfind("off_", 0) == 0;
    }
    EXPECT_EQ(images, times.size());
    EXPECT_EQ(off, 2U);
    for (std::size_t i = 1; i < times.size(); ++i)
        EXPECT_NEAR(times[i] - times[i - 1], 0.001, 1e-8);  // rad: times are whole nanoseconds

    const RecordingContents contents = load_recording(folder / "out/recording.stria");
    ASSERT_EQ(contents.frames.size(), times.size());
    const GreyImage last = read_grey_image(folder / "out/frame_00003.png");
    EXPECT_TRUE(std::equal(last.values.begin(), last.values.end(), contents.frames[3].bytes.begin(),
                           contents.frames[3].bytes.end()));
    // The log, read at the stamp and the scene's delay, agrees with the true positions.
    const auto state = position_at(contents.axis_log, contents.frames[5].row_time(40) + 20000);
    ASSERT_TRUE(state);
    EXPECT_NEAR(state->s, times[5], 5 * contents.axis_log.sigma_s);

    const RangeImage truth = read_range_image(folder / "out/truth.ply");
    EXPECT_EQ(truth.width, 100);
    EXPECT_GT(valid_count(truth), 3000U);
}

TEST(Simulate, KeepsWhatIsThereUnlessForced) {
    const TemporaryFolder folder;
    write_inputs(folder);
    const std::vector<std::string> once = {folder / "scene.toml", "--out", folder / "out", "--plan",
                                           folder / "plan.toml"};
    ASSERT_EQ(simulate(once), 0);
    EXPECT_EQ(simulate(once), 1);
    std::vector<std::string> again = once;
    again.push_back("--force");
    const std::string first = read_whole_file(folder / "out/recording.stria");
    ASSERT_EQ(simulate(again), 0);
    EXPECT_EQ(read_whole_file(folder / "out/recording.stria").size(), first.size());
}

TEST(Simulate, AnotherSeedIsAnotherNoise) {
    const TemporaryFolder folder;
    write_inputs(folder);
    const auto third_frame = [&](const std::string& out, const std::string& seed) {
        EXPECT_EQ(simulate({folder / "scene.toml", "--out", folder / out, "--plan",
                            folder / "plan.toml", "--frames", "--seed", seed}),
                  0);
        return read_whole_file(folder / (out + "/frame_00003.png"));
    };
    const std::string one = third_frame("a", "1");
    EXPECT_EQ(third_frame("b", "1"), one);
    EXPECT_NE(third_frame("c", "2"), one);
}

TEST(Simulate, RefusesAViewThatIsNotThere) {
    const TemporaryFolder folder;
    write_inputs(folder);
    EXPECT_EQ(simulate({folder / "scene.toml", "--out", folder / "out", "--view", "3"}), 1);
}

}  // namespace
}  // namespace stria

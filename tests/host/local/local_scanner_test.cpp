#include "host/local/local_scanner.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "firmware/protocol/codec.h"
#include "host/core/errors.h"
#include "tests/host/local/small_scene.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

class LocalScannerTest : public testing::Test {
  protected:
    void SetUp() override {
        const auto* info = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = fs::path(testing::TempDir()) / (std::string("stria_local_") + info->name());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    std::string path(const char* name) const { return (folder_ / name).string(); }
    static std::string read(const std::string& file) {
        std::ifstream in(file, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), {}};
    }
    fs::path folder_;
    Scene scene_ = small_scene();
};

/// Bytes of everything in a pulse map.
Bytes bytes_of(const PulseMap& map) { return encode(PulseBand{map, 0, map.height}); }

TEST_F(LocalScannerTest, DescribesItself) {
    LocalScanner device(scene_);
    const Snapshot info = device.info();
    EXPECT_TRUE(info.device.simulated);
    EXPECT_EQ(info.device.width, scene_.channel.camera.width);
    EXPECT_EQ(info.device.kind, "swept");
    EXPECT_NE(info.model_text.find("[[channel]]"), std::string::npos);
    EXPECT_EQ(std::get<double>(device.feature("ExposureTime").value), scene_.sensor.exposure_us);
}

TEST_F(LocalScannerTest, ScansAndItsRecordingReplaysToTheSame) {
    LocalScanner device(scene_);
    RunOptions options;
    options.recording_path = path("scan.stria");
    ScanPlan plan = small_sweep(scene_);
    plan.record = RecordWhat::both;
    const RecordingContents live = device.run(plan, options);
    ASSERT_TRUE(live.end);
    EXPECT_TRUE(live.end->complete) << live.end->reason;
    EXPECT_TRUE(live.notes.empty()) << live.notes[0];
    EXPECT_EQ(live.off_frames.size(), 2U);
    EXPECT_NEAR(static_cast<double>(live.frames.size()), 321.0, 1.0);
    ASSERT_EQ(live.pulse_maps.size(), 1U);
    EXPECT_GT(live.pulse_maps[0].pulses.size(), 1000U);

    const auto replay = open_device("replay:" + options.recording_path);
    RunOptions again;
    again.recording_path = path("again.stria");
    const RecordingContents replayed = replay->run(plan, again);
    EXPECT_TRUE(replayed.notes.empty());
    ASSERT_EQ(replayed.pulse_maps.size(), 1U);
    EXPECT_EQ(bytes_of(replayed.pulse_maps[0]), bytes_of(live.pulse_maps[0]));
    ASSERT_EQ(replayed.frames.size(), live.frames.size());
    EXPECT_EQ(replayed.frames[50].bytes, live.frames[50].bytes);
    EXPECT_EQ(read(again.recording_path), read(options.recording_path));
}

TEST_F(LocalScannerTest, TheSameSeedGivesTheSameBytesForAnyThreadCount) {
    for (int threads : {1, 3}) {
        OpenOptions options;
        options.seed = 5;
        options.threads = threads;
        LocalScanner device(scene_, options);
        RunOptions run;
        run.recording_path = path(threads == 1 ? "one.stria" : "three.stria");
        ASSERT_TRUE(device.run(small_sweep(scene_), run).end->complete);
    }
    EXPECT_EQ(read(path("one.stria")), read(path("three.stria")));
    EXPECT_FALSE(read(path("one.stria")).empty());
}

TEST_F(LocalScannerTest, RunsOneAfterTheOther) {
    LocalScanner device(scene_);
    ScanPlan plan = small_sweep(scene_);
    plan.step *= 4;
    plan.mode = StripeMode::spatial;
    for (int i = 0; i < 3; ++i) {
        const RecordingContents contents = device.run(plan);
        ASSERT_TRUE(contents.end->complete) << contents.end->reason;
        EXPECT_EQ(contents.pulse_maps.size(), 1U);
    }
}

TEST_F(LocalScannerTest, SceneViewChoosesTheView) {
    scene_.views = {{"all", {}, {}}, {"bare", {}, {}}};
    for (const SceneObject& object : scene_.objects) scene_.views[1].hidden.push_back(object.name);
    LocalScanner device(scene_);
    EXPECT_THROW(device.set_feature("SceneView", std::int64_t{2}), DeviceError);
    EXPECT_EQ(std::get<std::int64_t>(device.set_feature("SceneView", std::int64_t{1}).value), 1);
    EXPECT_EQ(device.scanner().view(), 1);
}

TEST_F(LocalScannerTest, AFailingCameraKeepsWhatCame) {
    scene_.fault.camera_stops_at_frame = 60;
    LocalScanner device(scene_);
    const RecordingContents contents = device.run(small_sweep(scene_));
    ASSERT_TRUE(contents.end);
    EXPECT_FALSE(contents.end->complete);
    EXPECT_FALSE(contents.end->reason.empty());
    EXPECT_GT(contents.end->frames, 20U);
    EXPECT_EQ(contents.pulse_maps.size(), 1U);
}

TEST_F(LocalScannerTest, ACallbackThatThrowsLeavesTheDeviceUsable) {
    LocalScanner device(scene_);
    ScanPlan plan = small_sweep(scene_);
    plan.record = RecordWhat::frames;
    RunOptions options;
    options.load.on_frame = [](const Frame&) { throw Error("enough"); };
    EXPECT_THROW(device.run(plan, options), Error);
    EXPECT_NO_THROW(device.info());
}

TEST_F(LocalScannerTest, UnknownKindsOfDeviceAreNamed) {
    try {
        open_device("usb:");
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("sim:SCENE.toml"), std::string::npos);
    }
}

TEST_F(LocalScannerTest, FastSpacetimeFindsThePulsesOfTheReference) {
    PulseMap reference, fast;
    for (PulseMap* map : {&reference, &fast}) {
        LocalScanner device(scene_);
        device.set_feature("FastSpacetime", map == &fast);
        *map = device.run(small_sweep(scene_)).pulse_maps.at(0);
    }
    ASSERT_GT(fast.pulses.size(), 1000U);
    EXPECT_EQ(fast.cell_begin, reference.cell_begin);
    ASSERT_EQ(fast.pulses.size(), reference.pulses.size());
    std::size_t of_other_bits = 0;
    for (std::size_t i = 0; i < fast.pulses.size(); ++i) {
        const Pulse &a = reference.pulses[i], &b = fast.pulses[i];
        EXPECT_LE(std::abs(static_cast<double>(a.t_ns - b.t_ns)), 0.1 * a.sigma + 0.002 * a.width);
        of_other_bits += a.t_ns != b.t_ns;
    }
    EXPECT_GT(of_other_bits, fast.pulses.size() / 4);  // it was not the reference again
}

TEST_F(LocalScannerTest, OfMoreThan8BitsTheReferenceAnalysesAndTheFeatureSaysSo) {
    scene_.sensor.bits = 12;
    LocalScanner device(scene_);
    const Feature feature = device.feature("FastSpacetime");
    EXPECT_EQ(std::get<bool>(feature.value), false);
    ASSERT_TRUE(feature.range);
    EXPECT_EQ(feature.range->max, 0.0);
    EXPECT_NE(feature.range->reason.find("the reference analyses this camera's 12"),
              std::string::npos);
    try {
        device.set_feature("FastSpacetime", true);
        ADD_FAILURE() << "12 bits were taken";
    } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find("8 bits"), std::string::npos) << error.what();
    }
    EXPECT_GT(device.run(small_sweep(scene_)).pulse_maps.at(0).pulses.size(), 1000U);
}

}  // namespace
}  // namespace stria

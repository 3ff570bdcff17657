#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "firmware/session/device_server.h"
#include "firmware/transport/socket.h"
#include "host/cli/run.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/io/whole_file.h"
#include "sim/striad_sim/served_scanner.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/host/local/small_scene.h"

/// The verbs that speak with a device, over the socket that a real one would have.
namespace stria {
namespace {

namespace fs = std::filesystem;

struct Said {
    int code = 0;
    std::string out, err;
};

Said stria(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Said said;
    said.code = run_program(static_cast<int>(argv.size()), argv.data());
    said.out = testing::internal::GetCapturedStdout();
    said.err = testing::internal::GetCapturedStderr();
    return said;
}

bool says(const std::string& text, const std::string& what) {
    return text.find(what) != std::string::npos;
}

/// A small simulated scanner on a Unix socket, until the end of the test.
class DeviceVerbs : public testing::Test {
  protected:
    DeviceVerbs() : scanner_(small_scene(), 1), server_(served_scanner(scanner_, 1), {}) {
        fs::create_directories(folder_ / "stria");
        const auto address = parse_address("unix:" + (folder_ / "stria/scanner"));
        auto listener = listen_socket(*address);
        EXPECT_TRUE(listener);
        listener_ = std::move(*listener);
        thread_ = std::thread([this] {
            while (!stop_) {
                auto client = listener_->accept(Milliseconds(50));
                if (client && *client) server_.serve(std::move(*client));
            }
        });
        device_ = "unix:" + (folder_ / "stria/scanner");
        write_whole_file(folder_ / "plan.toml",
                         "mode = \"spacetime\"\nfrom = -0.02\nto = 0.02\nstep = 0.0006\n"
                         "off_frames = 2\n");
    }
    ~DeviceVerbs() override {
        stop_ = true;
        thread_.join();
    }

    TemporaryFolder folder_;
    SimulatedScanner scanner_;
    DeviceServer server_;
    std::unique_ptr<Listener> listener_;
    std::thread thread_;
    std::atomic<bool> stop_ = false;
    std::string device_;
};

TEST_F(DeviceVerbs, DevicesFindsTheSocketAndNamesWhatDoesNotAnswer) {
    ::setenv("XDG_RUNTIME_DIR", std::string(folder_ / "").c_str(), 1);
    const Said said = stria({"devices", "--json", "unix:" + (folder_ / "nobody")});
    ::unsetenv("XDG_RUNTIME_DIR");
    EXPECT_EQ(said.code, 0);
    EXPECT_TRUE(says(said.out, "stria/scanner")) << said.out;
    EXPECT_TRUE(says(said.out, "\"kind\": \"swept\"")) << said.out;
    EXPECT_TRUE(says(said.out, "\"answers\": false")) << said.out;
    EXPECT_TRUE(says(said.err, "nobody  does not answer")) << said.err;
}

TEST_F(DeviceVerbs, InfoSaysWhatTheSceneIs) {
    const Said said = stria({"info", device_, "--json"});
    EXPECT_EQ(said.code, 0);
    const CameraModel camera = small_scene().channel.camera;
    EXPECT_TRUE(says(said.out, "\"width\": " + std::to_string(camera.width))) << said.out;
    EXPECT_TRUE(says(said.out, "\"simulated\": true"));
    EXPECT_TRUE(says(said.err, "swept, simulated")) << said.err;
}

TEST_F(DeviceVerbs, FeaturesAreReadSetAndRefusedWithTheirReason) {
    const Said all = stria({"features", device_, "--json"});
    EXPECT_EQ(all.code, 0);
    for (const char* name : {"ExposureTime", "limit_reason", "SceneView"})
        EXPECT_TRUE(says(all.out, name)) << name;
    const Said set = stria({"features", device_, "ExposureTime=1500"});
    EXPECT_EQ(set.code, 0) << set.err;
    EXPECT_TRUE(says(set.out, "1500")) << set.out;
    const Said far = stria({"features", device_, "ExposureTime=1e9"});
    EXPECT_EQ(far.code, 1);
    EXPECT_TRUE(says(far.err, "ExposureTime")) << far.err;
    EXPECT_TRUE(says(far.err, "expected")) << far.err;
    const Said unknown = stria({"features", device_, "ExposureTme"});
    EXPECT_EQ(unknown.code, 1);
    EXPECT_TRUE(says(unknown.err, "ExposureTme")) << unknown.err;
}

TEST_F(DeviceVerbs, ScanRangeReplayAndReportAgree) {
    const std::string part = folder_ / "part";
    // Without a calibration there is a recording and the way on, and no range image.
    Said said = stria({"scan", device_, "--out", part, "--plan", folder_ / "plan.toml"});
    ASSERT_EQ(said.code, 0) << said.err;
    EXPECT_TRUE(says(said.out, "stria calibrate scanner")) << said.out;
    // The scene's own model stands for a calibration.
    ScannerModel model;
    model.channels = {small_scene().channel};
    write_scanner(folder_ / "scanner.toml", model);
    said = stria({"scan", device_, "--out", part, "--plan", folder_ / "plan.toml", "--model",
                  folder_ / "scanner.toml", "--json"});
    ASSERT_EQ(said.code, 0) << said.err;
    EXPECT_TRUE(says(said.out, "\"complete\": true")) << said.out;

    std::vector<std::string> ranges;
    for (const auto& entry : fs::recursive_directory_iterator(part))
        if (entry.path().filename() == "range.ply") ranges.push_back(entry.path().string());
    ASSERT_EQ(ranges.size(), 1U);
    const fs::path scan = fs::path(ranges[0]).parent_path();
    const std::string recording = (scan / "recording.stria").string();

    ASSERT_EQ(stria({"replay", recording, "--out", folder_ / "again"}).code, 0);
    EXPECT_EQ(read_whole_file(folder_ / "again/range.ply"), read_whole_file(ranges[0]));
    EXPECT_EQ(read_whole_file(folder_ / "again/recording.stria"), read_whole_file(recording));
    ASSERT_EQ(stria({"range", recording, "--model", folder_ / "scanner.toml", "--out",
                     folder_ / "range.ply"})
                  .code,
              0);
    EXPECT_EQ(read_whole_file(folder_ / "range.ply"), read_whole_file(ranges[0]));
    const Said info = stria({"info", "replay:" + recording, "--json"});
    EXPECT_EQ(info.code, 0);
    EXPECT_TRUE(says(info.out, "\"plan\"")) << info.out;
    const Said report = stria({"report", part, "--out", folder_ / "report.html"});
    EXPECT_EQ(report.code, 0) << report.err;
    EXPECT_TRUE(says(read_whole_file(folder_ / "report.html"), "data:image/png"));
}

TEST_F(DeviceVerbs, ScanChoosesTheFastAnalysisAndItsRecordingSaysSo) {
    const std::string part = folder_ / "part";
    Said said = stria(
        {"scan", device_, "--out", part, "--plan", folder_ / "plan.toml", "--fast", "--json"});
    ASSERT_EQ(said.code, 0) << said.err;
    EXPECT_TRUE(says(said.out, "\"fast\": true")) << said.out;
    said = stria({"features", "replay:" + part + "/scans/0001/recording.stria", "FastSpacetime"});
    EXPECT_TRUE(says(said.out, "FastSpacetime = true")) << said.out;
    write_whole_file(folder_ / "spatial.toml",
                     "mode = \"spatial\"\nfrom = -0.02\nto = 0.02\nstep = 0.0006\n");
    said = stria({"scan", device_, "--out", part, "--plan", folder_ / "spatial.toml", "--fast"});
    EXPECT_EQ(said.code, 1);
    EXPECT_TRUE(says(said.err, "--fast: expected a plan")) << said.err;
}

TEST_F(DeviceVerbs, WhatCannotBeIsRefusedAndLeavesNothingBehind) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(stria({"info", "unix:" + (folder_ / "nobody")}).code, 1);
    EXPECT_EQ(stria({"info", "serial:/dev/ttyS0"}).code, 1);
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
    write_whole_file(folder_ / "far.toml",
                     "mode = \"spacetime\"\nfrom = -3\nto = 3\nstep = 0.0006\n");
    const Said far =
        stria({"scan", device_, "--out", folder_ / "part", "--plan", folder_ / "far.toml"});
    EXPECT_EQ(far.code, 1);
    EXPECT_TRUE(says(far.err, "from")) << far.err;
    for (const auto& entry : fs::recursive_directory_iterator(folder_ / "part"))
        EXPECT_NE(entry.path().extension(), ".ply");
}

}  // namespace
}  // namespace stria

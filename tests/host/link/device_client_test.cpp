#include "host/link/device_client.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "firmware/protocol/recording.h"
#include "firmware/transport/socket.h"
#include "host/core/errors.h"
#include "host/link/discover.h"
#include "tests/firmware/session/test_client.h"

namespace stria {
namespace {

namespace fs = std::filesystem;
using SteadyClock = std::chrono::steady_clock;

/// A fake machine behind a real socket, accepting on a thread of its own.
class Served {
  public:
    explicit Served(const std::string& address, Milliseconds frame_time = Milliseconds(0),
                    bool moves_part = false)
        : session({}, frame_time, moves_part) {
        auto opened = listen_socket(*parse_address(address));
        EXPECT_TRUE(opened) << opened.failure().message;
        listener_ = std::move(*opened);
        uri = to_string(listener_->address());
        thread_ = std::thread([this] {
            while (!stop_) {
                auto stream = listener_->accept(Milliseconds(20));
                if (stream && *stream) session.server->serve(std::move(*stream));
            }
        });
    }
    ~Served() {
        stop_ = true;
        thread_.join();
    }

    FakeSession session;
    std::string uri;

  private:
    std::unique_ptr<Listener> listener_;
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

std::string socket_address(const char* name) {
    return "unix:" +
           (fs::temp_directory_path() / ("stria_link_" + std::to_string(::getpid()) + "_" + name))
               .string();
}

std::string message_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing was thrown";
}

class OverKinds : public testing::TestWithParam<const char*> {
  protected:
    std::string address() const {
        return GetParam() == std::string("unix") ? socket_address("kinds") : "tcp:127.0.0.1:0";
    }
};

TEST_P(OverKinds, RunsAPlanAndRecordsIt) {
    Served served(address());
    const auto device = connect_device(served.uri);
    EXPECT_EQ(device->info().device.model_name, "fake scanner");
    EXPECT_EQ(std::get<double>(device->set_feature("ExposureTime", 500.0).value), 500.0);
    RunOptions options;
    options.recording_path = testing::TempDir() + "link_" + GetParam() + ".stria";
    std::uint32_t frames = 0;
    options.progress = [&](const RunProgress& progress) { frames = progress.frames; };
    const RecordingContents live = device->run(FakeSession::plan(), options);
    ASSERT_TRUE(live.end);
    EXPECT_TRUE(live.end->complete) << live.end->reason;
    EXPECT_EQ(live.frames.size(), live.end->frames);
    EXPECT_EQ(live.pulse_maps.size(), 1U);
    EXPECT_GT(frames, 0U);

    const RecordingContents loaded = load_recording(options.recording_path);
    EXPECT_TRUE(loaded.notes.empty());
    EXPECT_EQ(loaded.frames.size(), live.frames.size());
    EXPECT_EQ(loaded.pulse_maps[0].pulses.size(), live.pulse_maps[0].pulses.size());
    fs::remove(options.recording_path);
}

INSTANTIATE_TEST_SUITE_P(Kinds, OverKinds, testing::Values("unix", "tcp"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST(DeviceClient, TellsTheDevicesOwnReason) {
    Served served(socket_address("reasons"));
    const auto device = connect_device(served.uri);
    EXPECT_NE(message_of([&] {
                  device->set_feature("Width", std::int64_t{1});
              }).find("Width can only be read"),
              std::string::npos);
    ScanPlan plan = FakeSession::plan();
    plan.from = -5;
    EXPECT_NE(message_of([&] { device->run(plan); }).find("from = -5"), std::string::npos);
    const auto second = connect_device(served.uri);
    EXPECT_NE(message_of([&] { second->run(FakeSession::plan()); }).find("has control"),
              std::string::npos);
}

TEST(DeviceClient, ARunThatTheDeviceEndsKeepsWhatCame) {
    Served served(socket_address("ends"));
    served.session.machine.silent_from_frame = 25;
    const RecordingContents contents = connect_device(served.uri)->run(FakeSession::plan());
    ASSERT_TRUE(contents.end);
    EXPECT_FALSE(contents.end->complete);
    EXPECT_EQ(contents.end->reason, "the camera gave no frame in time");
    EXPECT_GT(contents.frames.size(), 5U);
    EXPECT_EQ(contents.pulse_maps.size(), 1U);
}

TEST(DeviceClient, ADeviceThatDoesNotAnswerIsAnErrorInTime) {
    auto listener = listen_socket(*parse_address(socket_address("mute")));
    ASSERT_TRUE(listener);
    const auto begin = SteadyClock::now();
    const std::string message = message_of(
        [&] { connect_device(to_string((*listener)->address()), {.timeout = Milliseconds(300)}); });
    EXPECT_NE(message.find("300 ms"), std::string::npos) << message;
    EXPECT_LT(SteadyClock::now() - begin, Milliseconds(3000));
}

TEST(DeviceClient, ADeviceThatIsNotThereIsAnErrorAtOnce) {
    EXPECT_NE(
        message_of([] { connect_device(socket_address("nobody")); }).find("nothing listens there"),
        std::string::npos);
}

TEST(DeviceClient, AnswersThatAreNoMessagesAreAnError) {
    auto [there, here] = make_memory_streams("bad");
    ASSERT_TRUE(there->write_all(Bytes(100, 'q'), Milliseconds(1000)));
    auto listener = listen_socket(*parse_address(socket_address("bad")));
    std::thread server([&] {
        auto stream = (*listener)->accept(Milliseconds(5000));
        ASSERT_TRUE(stream && *stream);
        EXPECT_TRUE((*stream)->write_all(Bytes(100, 'q'), Milliseconds(1000)));
        std::this_thread::sleep_for(Milliseconds(300));
    });
    const std::string message =
        message_of([&] { connect_device(to_string((*listener)->address())); });
    EXPECT_NE(message.find("magic"), std::string::npos) << message;
    server.join();
}

TEST(DeviceClient, ALinkThatBreaksKeepsTheRecordingSoFar) {
    Served served(socket_address("breaks"));
    std::atomic<int> frames = 0;
    served.session.machine.on_frame = [&] {
        std::this_thread::sleep_for(Milliseconds(40));
        ++frames;
    };
    const auto device = connect_device(served.uri);
    RunOptions options;
    options.recording_path = testing::TempDir() + "link_breaks.stria";
    std::thread breaker([&] {
        FakeSession::eventually([&] { return frames >= 8; });  // the off frame is long on its way
        served.session.server.reset();
    });
    const std::string why = message_of([&] { device->run(FakeSession::plan(), options); });
    breaker.join();
    EXPECT_NE(why.find("stria_link"), std::string::npos) << why;
    const RecordingContents kept = load_recording(options.recording_path);
    EXPECT_EQ(kept.off_frames.size(), 1U) << why;
    EXPECT_FALSE(kept.end && kept.end->complete);
    fs::remove(options.recording_path);
}

TEST(DeviceClient, ARecordingIsADeviceThatCanOnlyBeRead) {
    Served served(socket_address("replay"));
    RunOptions options;
    options.recording_path = testing::TempDir() + "link_replay.stria";
    connect_device(served.uri)->run(FakeSession::plan(), options);
    const auto replay = connect_device("replay:" + options.recording_path);
    EXPECT_EQ(replay->info().device.model_name, "fake scanner");
    EXPECT_EQ(replay->feature("ExposureTime").access, Access::read);
    EXPECT_THROW(replay->set_feature("ExposureTime", 1.0), DeviceError);
    EXPECT_THROW(replay->feature("Nothing"), DeviceError);
    EXPECT_TRUE(replay->run(FakeSession::plan()).notes.empty());
    ScanPlan other = FakeSession::plan();
    other.to = 2;
    EXPECT_EQ(replay->run(other).notes.size(), 1U);
    fs::remove(options.recording_path);
}

TEST(DeviceClient, SaysWhichKindsOfDeviceThereAre) {
    EXPECT_NE(message_of([] { connect_device("serial:1"); }).find("replay:FILE"),
              std::string::npos);
}

TEST(FeatureValueText, IsReadAsTheFeaturesType) {
    Feature feature;
    feature.name = "F";
    feature.value = 1.5;
    EXPECT_EQ(std::get<double>(parse_feature_value(feature, "2.25")), 2.25);
    EXPECT_THROW(parse_feature_value(feature, "2.25us"), Error);
    feature.value = std::int64_t{1};
    EXPECT_EQ(std::get<std::int64_t>(parse_feature_value(feature, "-3")), -3);
    EXPECT_THROW(parse_feature_value(feature, ""), Error);
    feature.value = true;
    EXPECT_FALSE(std::get<bool>(parse_feature_value(feature, "false")));
    EXPECT_THROW(parse_feature_value(feature, "no"), Error);
    EXPECT_EQ(to_string(FeatureValue(0.1)), "0.1");
}

TEST(Discover, FindsSocketsAndNothingElse) {
    const fs::path folder = fs::temp_directory_path() / ("stria_run_" + std::to_string(::getpid()));
    fs::create_directories(folder);
    std::ofstream(folder / "notes.txt") << "no socket";
    auto listener = listen_socket(*parse_address("unix:" + (folder / "a.sock").string()));
    ASSERT_TRUE(listener);
    EXPECT_EQ(find_sockets({folder.string(), "/no/such/folder"}),
              std::vector<std::string>{"unix:" + (folder / "a.sock").string()});
    listener = Failure{};
    fs::remove_all(folder);
}

}  // namespace
}  // namespace stria

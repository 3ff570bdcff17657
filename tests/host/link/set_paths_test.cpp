#include <gtest/gtest.h>

#include <thread>

#include "firmware/transport/memory_stream.h"
#include "host/core/errors.h"
#include "host/link/link_client.h"
#include "tests/firmware/session/test_client.h"

namespace stria {
namespace {

std::string message_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const DeviceError& error) {
        return error.what();
    }
    return "nothing was thrown";
}

ScanPlan rail_plan() {
    ScanPlan plan = FakeSession::plan();
    plan.mode = StripeMode::spacetime;
    plan.step = 0.05;
    return plan;
}

struct Rail {
    Rail() : session({}, Milliseconds(0), true) {
        auto [there, here] = make_memory_streams("rail");
        session.server->serve(std::move(there));
        device = make_link_client(std::move(here));
    }
    FakeSession session;
    std::unique_ptr<DeviceClient> device;
};

TEST(SetPathsOverTheLink, ARunFollowsThemAndReplaysToTheSame) {
    Rail rail;
    EXPECT_NE(message_of([&] { rail.device->run(rail_plan()); }).find("image paths"),
              std::string::npos);
    rail.device->set_paths({FakeMachine::paths()});
    RunOptions options;
    options.recording_path = testing::TempDir() + "link_paths.stria";
    const RecordingContents live = rail.device->run(rail_plan(), options);
    ASSERT_TRUE(live.end && live.end->complete);
    EXPECT_EQ(live.path_tables, std::vector<PathTable>{FakeMachine::paths()});
    ASSERT_EQ(live.pulse_maps.size(), 1U);

    const auto replay = make_replay_client(options.recording_path);
    replay->set_paths({FakeMachine::paths()});
    const RecordingContents again = replay->run(rail_plan());
    EXPECT_TRUE(again.notes.empty());
    EXPECT_EQ(encode(PulseBand{again.pulse_maps[0], 0, again.pulse_maps[0].height}),
              encode(PulseBand{live.pulse_maps[0], 0, live.pulse_maps[0].height}));
    PathTable other = FakeMachine::paths();
    other.model_hash = "fedcba9876543210";
    replay->set_paths({other});
    ASSERT_EQ(replay->run(rail_plan()).notes.size(), 1U);
    std::remove(options.recording_path.c_str());

    rail.device->set_paths({});
    EXPECT_NE(message_of([&] { rail.device->run(rail_plan()); }).find("image paths"),
              std::string::npos);
}

TEST(SetPathsOverTheLink, ATableThatIsNotUsableIsNotSent) {
    Rail rail;
    PathTable table = FakeMachine::paths();
    table.valid[1] = 7;
    EXPECT_THROW(rail.device->set_paths({table}), std::invalid_argument);
    EXPECT_NO_THROW(rail.device->info());
}

/// A device that answers a hello and tells those features; a third request is cut off.
std::thread scripted_device(ByteStream& stream, const std::vector<Feature>& features) {
    return std::thread([&stream, features] {
        for (int answered = 0; answered < 2;) {
            const auto read = read_message(stream, Milliseconds(5000));
            if (!read || !read->message) return;
            const auto message = decode(read->message->header.type, read->message->payload);
            const Request request = std::get<Request>(*message);
            if (request.id == 0) continue;  // a heartbeat
            Response response;
            response.id = request.id;
            response.features = features;
            (void)write_message(stream,
                                make_raw(WireChannel::control, MessageType::response,
                                         encode(response), 0, static_cast<std::uint32_t>(answered)),
                                Milliseconds(5000));
            ++answered;
        }
        Bytes some(40);
        (void)stream.read_some(some, Milliseconds(5000));
        stream.close();
    });
}

TEST(SetPathsOverTheLink, OlderFirmwareIsNamed) {
    auto [there, here] = make_memory_streams("old");
    std::thread device = scripted_device(*there, {});
    const auto client = make_link_client(std::move(here));
    EXPECT_NE(message_of([&] {
                  client->set_paths({FakeMachine::paths()});
              }).find("older than image paths"),
              std::string::npos);
    there->close();
    device.join();
}

TEST(SetPathsOverTheLink, ADeviceThatGoesDuringTheUploadIsAnErrorInTime) {
    Feature paths;
    paths.name = "ImagePaths";
    paths.value = std::string("none");
    auto [there, here] = make_memory_streams("going");
    std::thread device = scripted_device(*there, {paths});
    const auto begin = std::chrono::steady_clock::now();
    const auto client = make_link_client(std::move(here), {.timeout = Milliseconds(2000)});
    const std::string why = message_of([&] { client->set_paths({FakeMachine::paths()}); });
    EXPECT_NE(why.find("going"), std::string::npos) << why;
    EXPECT_NE(why.find("closed"), std::string::npos) << why;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, Milliseconds(10'000));
    device.join();
}

}  // namespace
}  // namespace stria

#include "firmware/session/device_server.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "firmware/protocol/recording.h"
#include "firmware/transport/socket.h"
#include "tests/firmware/session/test_client.h"

namespace stria {
namespace {

constexpr std::uint64_t kMuch = std::uint64_t{1} << 30;

TEST(DeviceServer, ExpectsAHelloFirst) {
    FakeSession session;
    TestClient client(*session.server);
    EXPECT_FALSE(client.ask(RequestVerb::features).ok);
    EXPECT_EQ(client.hello("a").role, Role::control);
    EXPECT_TRUE(client.ask(RequestVerb::features).ok);
}

TEST(DeviceServer, DescribesTheMachine) {
    FakeSession session;
    TestClient client(*session.server);
    client.hello("a", Role::watch);
    const Response response = client.ask(RequestVerb::describe);
    ASSERT_TRUE(response.snapshot);
    EXPECT_EQ(response.snapshot->device.model_name, "fake scanner");
    EXPECT_EQ(response.snapshot->device.width, FakeMachine::kWidth);
    EXPECT_EQ(response.snapshot->model_text, "# a model");
}

TEST(DeviceServer, OneControlsOthersWatch) {
    FakeSession session;
    auto first = std::make_unique<TestClient>(*session.server);
    TestClient second(*session.server);
    EXPECT_EQ(first->hello("first").role, Role::control);
    const Response told = second.hello("second");
    EXPECT_EQ(told.role, Role::watch);
    EXPECT_NE(told.error.find("first has control"), std::string::npos);
    const Response refused = second.start(FakeSession::plan());
    EXPECT_FALSE(refused.ok);
    EXPECT_NE(refused.error.find("first has control"), std::string::npos);
    EXPECT_FALSE(
        second.ask({.verb = RequestVerb::set_feature, .name = "ExposureTime", .value = 500.0}).ok);
    first.reset();
    EXPECT_TRUE(FakeSession::eventually([&] { return session.server->client_count() == 1; }));
    EXPECT_EQ(second.hello("second").role, Role::control);
    EXPECT_TRUE(
        second.ask({.verb = RequestVerb::set_feature, .name = "ExposureTime", .value = 500.0}).ok);
}

TEST(DeviceServer, ControlPassesToWhoAsksWhileTheOtherIsLeaving) {
    FakeSession session;
    auto first = std::make_unique<TestClient>(*session.server);
    TestClient second(*session.server);
    EXPECT_EQ(first->hello("first").role, Role::control);
    std::thread leaving([&] {
        std::this_thread::sleep_for(Milliseconds(50));
        first.reset();
    });
    EXPECT_EQ(second.hello("second").role, Role::control);
    leaving.join();
}

TEST(DeviceServer, ARunSendsItsMessagesInOrder) {
    FakeSession session;
    TestClient client(*session.server);
    client.hello("a");
    const Response started = client.start(FakeSession::plan());
    ASSERT_TRUE(started.ok) << started.error;
    EXPECT_EQ(started.run, 1U);
    client.credit(kMuch);
    const End end = client.read_to_end();
    EXPECT_TRUE(end.complete) << end.reason;
    std::vector<MessageType> kinds;
    for (std::size_t i = 0; i < client.data.size(); ++i) {
        EXPECT_EQ(client.data[i].header.session, 1U);
        EXPECT_EQ(client.data[i].header.sequence, i);
        const MessageType type = client.data[i].header.type;
        if (kinds.empty() || kinds.back() != type) kinds.push_back(type);
    }
    EXPECT_EQ(kinds, (std::vector<MessageType>{MessageType::snapshot, MessageType::frame,
                                               MessageType::axis_log, MessageType::frame,
                                               MessageType::axis_log, MessageType::pulse_band,
                                               MessageType::end}));
    EXPECT_EQ(client.ask(RequestVerb::heartbeat).ok, true);
    ASSERT_FALSE(client.health.empty());
    EXPECT_EQ(client.health.back().state, DeviceState::idle);
    EXPECT_FALSE(client.health.back().laser_on);
    EXPECT_TRUE(session.is_safe());
}

TEST(DeviceServer, RefusesAPlanThatTheMachineCannotDo) {
    FakeSession session;
    TestClient client(*session.server);
    client.hello("a");
    ScanPlan plan = FakeSession::plan();
    plan.to = 100;
    const Response response = client.start(plan);
    EXPECT_FALSE(response.ok);
    EXPECT_NE(response.error.find("to = 100"), std::string::npos);
    plan = FakeSession::plan();
    EXPECT_TRUE(
        client.ask({.verb = RequestVerb::set_feature, .name = "LaserPower", .value = 0.5}).ok);
    EXPECT_NE(client.start(plan).error.find("LaserPower"), std::string::npos);
    EXPECT_EQ(session.machine.emission_s, 0);
}

// The client gives no credit, so data piles up; answers and stop go past it.
TEST(DeviceServer, HeartbeatAndStopNeverWaitBehindData) {
    FakeSession session({.max_data_bytes = 4000}, Milliseconds(1));
    TestClient client(*session.server);
    client.hello("a");
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);
    EXPECT_TRUE(FakeSession::eventually([&] { return session.machine.laser_on.load(); }));
    for (int i = 0; i < 5; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        EXPECT_TRUE(client.ask(RequestVerb::heartbeat).ok);
        EXPECT_LT(std::chrono::steady_clock::now() - begin, Milliseconds(2000));
    }
    EXPECT_TRUE(client.data.empty());
    EXPECT_TRUE(client.ask(RequestVerb::stop).ok);
    EXPECT_TRUE(FakeSession::eventually([&] { return !session.machine.laser_on; }));
    client.credit(kMuch);
    EXPECT_FALSE(client.read_to_end().complete);
}

TEST(DeviceServer, AClientThatTakesNoDataEndsItsRun) {
    FakeSession session({.data_stall = Milliseconds(100), .max_data_bytes = 4000});
    TestClient client(*session.server);
    client.hello("a");
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);
    EXPECT_TRUE(FakeSession::eventually([&] { return !session.server->is_running(); }));
    EXPECT_TRUE(session.is_safe());
    EXPECT_TRUE(client.ask(RequestVerb::heartbeat).ok);
}

TEST(DeviceServer, ALostHeartbeatEndsInTheSafeState) {
    FakeSession session({.heartbeat_timeout = Milliseconds(300)}, Milliseconds(100));
    TestClient client(*session.server), watcher(*session.server);
    client.hello("silent one");
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);  // some 30 frames of 100 ms
    client.credit(kMuch);
    EXPECT_TRUE(FakeSession::eventually([&] { return session.machine.laser_on.load(); }));
    EXPECT_TRUE(FakeSession::eventually([&] { return !session.server->is_running(); }));
    EXPECT_TRUE(session.is_safe());
    EXPECT_LT(session.machine.now, 2 * kNsPerSecond);  // well before the sweep's end
    EXPECT_TRUE(client.is_closed_within(Milliseconds(5000)));
}

TEST(DeviceServer, AClosedConnectionEndsInTheSafeState) {
    FakeSession session({}, Milliseconds(20));
    TestClient watcher(*session.server);
    watcher.hello("watcher", Role::watch);
    {
        TestClient client(*session.server);
        client.hello("a");
        ASSERT_TRUE(client.start(FakeSession::plan()).ok);
        client.credit(kMuch);
        EXPECT_TRUE(FakeSession::eventually([&] { return session.machine.laser_on.load(); }));
    }
    EXPECT_TRUE(FakeSession::eventually([&] { return !session.server->is_running(); }));
    EXPECT_TRUE(session.is_safe());
    watcher.ask(RequestVerb::heartbeat);
    ASSERT_FALSE(watcher.health.empty());
    EXPECT_NE(watcher.health.back().message.find("a was lost"), std::string::npos)
        << watcher.health.back().message;
}

TEST(DeviceServer, DestroyedDuringARunItLeavesTheMachineSafe) {
    FakeSession session({}, Milliseconds(10));
    TestClient client(*session.server);
    client.hello("a");
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);
    EXPECT_TRUE(FakeSession::eventually([&] { return session.machine.laser_on.load(); }));
    session.server.reset();
    EXPECT_TRUE(session.is_safe());
}

TEST(DeviceServer, EveryClientMayStopARun) {
    FakeSession session({}, Milliseconds(20));
    TestClient client(*session.server), watcher(*session.server);
    client.hello("a");
    watcher.hello("b", Role::watch);
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);
    EXPECT_FALSE(client.start(FakeSession::plan()).ok);  // one at a time
    client.credit(kMuch);
    EXPECT_TRUE(FakeSession::eventually([&] { return session.machine.laser_on.load(); }));
    EXPECT_TRUE(watcher.ask(RequestVerb::stop).ok);
    const End end = client.read_to_end();
    EXPECT_FALSE(end.complete);
    EXPECT_EQ(end.reason, "stopped on request");
    EXPECT_TRUE(session.is_safe());
}

TEST(DeviceServer, AWatcherMayTakeDataToo) {
    FakeSession session;
    TestClient client(*session.server), watcher(*session.server);
    client.hello("a");
    watcher.hello("b", Role::watch);
    EXPECT_TRUE(watcher.ask({.verb = RequestVerb::select, .channels = kSelectData}).ok);
    watcher.credit(kMuch);
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);
    client.credit(kMuch);
    client.read_to_end();
    watcher.read_to_end();
    ASSERT_EQ(watcher.data.size(), client.data.size());
    for (std::size_t i = 0; i < client.data.size(); ++i)
        EXPECT_EQ(watcher.data[i].payload, client.data[i].payload);
}

TEST(DeviceServer, AWatcherThatReadsTooSlowlyLosesTheDataNotTheRun) {
    FakeSession session({.max_data_bytes = 4000});
    TestClient client(*session.server), watcher(*session.server);
    client.hello("a");
    watcher.hello("b", Role::watch);
    EXPECT_TRUE(
        watcher.ask({.verb = RequestVerb::select, .channels = kSelectData | kSelectHealth}).ok);
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);  // the watcher gives no credit
    client.credit(kMuch);
    EXPECT_TRUE(client.read_to_end().complete);
    EXPECT_TRUE(watcher.ask(RequestVerb::heartbeat).ok);
    bool was_told = false;
    for (const Health& health : watcher.health)
        was_told = was_told || health.message.find("too slowly") != std::string::npos;
    EXPECT_TRUE(was_told);
}

TEST(DeviceServer, KeepsARunUntilItIsAcknowledged) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "stria_spool";
    std::filesystem::create_directories(folder);
    FakeSession session({.spool_folder = folder.string()});
    TestClient client(*session.server);
    client.hello("a");
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);
    client.credit(kMuch);
    ASSERT_TRUE(client.read_to_end().complete);
    const std::string kept = (folder / "run-1.stria").string();
    auto reader = RecordingReader::open(kept);
    ASSERT_TRUE(reader) << reader.failure().message;
    EXPECT_EQ(reader->snapshot_message().payload, client.data[0].payload);
    for (std::size_t i = 1; i < client.data.size(); ++i) {
        const auto raw = reader->next_raw();
        ASSERT_TRUE(raw && *raw);
        EXPECT_EQ((*raw)->payload, client.data[i].payload);
    }
    EXPECT_FALSE(client.ask({.verb = RequestVerb::ack, .run = 2}).ok);
    EXPECT_TRUE(client.ask({.verb = RequestVerb::ack, .run = 1}).ok);
    EXPECT_FALSE(std::filesystem::exists(kept));
    std::filesystem::remove_all(folder);
}

TEST(DeviceServer, DropsAClientThatSendsGarbageAndLivesOn) {
    FakeSession session;
    TestClient bad(*session.server), good(*session.server);
    ASSERT_TRUE(bad.stream().write_all(Bytes(500, 'z'), Milliseconds(1000)));
    EXPECT_TRUE(bad.is_closed_within(Milliseconds(5000)));
    EXPECT_TRUE(good.hello("a").ok);
    TestClient wrong(*session.server);
    ASSERT_TRUE(write_message(wrong.stream(),
                              make_raw(WireChannel::data, MessageType::end, encode(End{}), 0, 0),
                              Milliseconds(1000)));
    EXPECT_TRUE(wrong.is_closed_within(Milliseconds(5000)));
}

/// The same over real sockets.
class OverSocket : public testing::TestWithParam<const char*> {};

TEST_P(OverSocket, ServesTwoClients) {
    FakeSession session;
    auto listener = listen_socket(*parse_address(GetParam()));
    ASSERT_TRUE(listener) << listener.failure().message;
    const auto connect = [&] {
        auto stream = connect_socket((*listener)->address(), Milliseconds(5000));
        EXPECT_TRUE(stream);
        auto accepted = (*listener)->accept(Milliseconds(5000));
        EXPECT_TRUE(accepted && *accepted);
        session.server->serve(std::move(*accepted));
        return TestClient(std::move(*stream));
    };
    TestClient client = connect(), watcher = connect();
    EXPECT_EQ(client.hello("a").role, Role::control);
    EXPECT_EQ(watcher.hello("b").role, Role::watch);
    ASSERT_TRUE(client.start(FakeSession::plan()).ok);
    client.credit(kMuch);
    EXPECT_TRUE(client.read_to_end().complete);
    EXPECT_TRUE(watcher.ask(RequestVerb::features).ok);
    EXPECT_FALSE(watcher.health.empty());
}

INSTANTIATE_TEST_SUITE_P(Kinds, OverSocket,
                         testing::Values("unix:/tmp/stria_session_test.sock", "tcp:127.0.0.1:0"),
                         [](const auto& kind) {
                             return std::string(kind.param).substr(0, 3) == "tcp" ? "tcp" : "unix";
                         });

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include "tests/firmware/session/test_client.h"

/// Image paths on their way to the device, and what becomes of a link that breaks then.
namespace stria {
namespace {

constexpr std::uint64_t kMuch = std::uint64_t{1} << 30;

struct Rail : FakeSession {
    explicit Rail(Milliseconds frame_time = Milliseconds(0)) : FakeSession({}, frame_time, true) {}
    static ScanPlan plan() {
        ScanPlan plan = FakeSession::plan();
        plan.mode = StripeMode::spacetime;
        plan.step = 0.05;
        return plan;
    }
};

Request upload(const PathTable& table) { return {.verb = RequestVerb::set_paths, .paths = table}; }

std::string image_paths(TestClient& client) {
    const Response told = client.ask({.verb = RequestVerb::features, .name = "ImagePaths"});
    return std::get<std::string>(told.features.at(0).value);
}

TEST(SetPaths, ARunFollowsThemAndItsRecordingHoldsThem) {
    Rail rail;
    TestClient client(*rail.server);
    client.hello("a");
    const Response refused = client.start(Rail::plan());
    EXPECT_FALSE(refused.ok);
    EXPECT_NE(refused.error.find("image paths"), std::string::npos) << refused.error;
    EXPECT_NE(image_paths(client).find("none"), std::string::npos);

    ASSERT_TRUE(client.ask(upload(FakeMachine::paths())).ok);
    EXPECT_EQ(image_paths(client), "laser 0: model 0123456789abcdef");
    ASSERT_TRUE(client.start(Rail::plan()).ok);
    client.credit(kMuch);
    const End end = client.read_to_end();
    EXPECT_TRUE(end.complete) << end.reason;
    ASSERT_GT(client.data.size(), 2U);
    ASSERT_EQ(client.data[1].header.type, MessageType::path_table);
    const auto table = decode(MessageType::path_table, client.data[1].payload);
    ASSERT_TRUE(table);
    EXPECT_EQ(std::get<PathTable>(*table), FakeMachine::paths());
    const RawMessage& band = client.data[client.data.size() - 2];
    ASSERT_EQ(band.header.type, MessageType::pulse_band);
    const PulseMap map = std::get<PulseBand>(*decode(band.header.type, band.payload)).map;
    EXPECT_EQ(map.mode, StripeMode::spacetime);
    EXPECT_GT(map.pulses.size(), 500U);
}

TEST(SetPaths, TheyAreForgottenOnRequestAndWithTheirClient) {
    Rail rail;
    {
        TestClient client(*rail.server);
        client.hello("a");
        ASSERT_TRUE(client.ask(upload(FakeMachine::paths())).ok);
        ASSERT_TRUE(client.ask(RequestVerb::set_paths).ok);
        EXPECT_NE(image_paths(client).find("none"), std::string::npos);
        ASSERT_TRUE(client.ask(upload(FakeMachine::paths())).ok);
    }
    EXPECT_TRUE(FakeSession::eventually([&] { return rail.server->client_count() == 0; }));
    TestClient next(*rail.server);
    next.hello("b");
    EXPECT_NE(image_paths(next).find("none"), std::string::npos);
    EXPECT_FALSE(next.start(Rail::plan()).ok);
}

TEST(SetPaths, OnlyWhoControlsMaySendThemAndNotDuringARun) {
    Rail rail(Milliseconds(20));
    TestClient client(*rail.server), watcher(*rail.server);
    client.hello("a");
    watcher.hello("b", Role::watch);
    EXPECT_NE(watcher.ask(upload(FakeMachine::paths())).error.find("a has control"),
              std::string::npos);
    ASSERT_TRUE(client.ask(upload(FakeMachine::paths())).ok);
    ASSERT_TRUE(client.start(Rail::plan()).ok);
    EXPECT_NE(client.ask(upload(FakeMachine::paths())).error.find("a run is going on"),
              std::string::npos);
    ASSERT_TRUE(client.ask(RequestVerb::stop).ok);
    EXPECT_TRUE(FakeSession::eventually([&] { return !rail.server->is_running(); }));
    EXPECT_TRUE(rail.is_safe());
}

TEST(SetPaths, RefusesPathsOfAnotherCameraAndOnASweptMachine) {
    PathTable wide = FakeMachine::paths();
    wide.image_width = 640;
    Rail rail;
    TestClient client(*rail.server);
    client.hello("a");
    EXPECT_NE(client.ask(upload(wide)).error.find("640 x 24"), std::string::npos);
    FakeSession swept;
    TestClient other(*swept.server);
    other.hello("a");
    EXPECT_EQ(image_paths(other), "pixels");
    EXPECT_NE(other.ask(upload(FakeMachine::paths())).error.find("surface points"),
              std::string::npos);
}

// decode() refuses what the table holds; the answer still bears the request's number.
TEST(SetPaths, ATableThatIsNotUsableIsAnsweredWithItsFault) {
    PathTable broken = FakeMachine::paths();
    broken.du_ds.pop_back();
    Rail rail;
    TestClient client(*rail.server);
    client.hello("a");
    const Response told = client.ask(upload(broken));
    EXPECT_FALSE(told.ok);
    EXPECT_NE(told.error.find("paths: path column"), std::string::npos) << told.error;
    EXPECT_TRUE(client.ask(RequestVerb::heartbeat).ok);
}

// At every cut the server loses that client, keeps nothing of the table and serves the next.
TEST(SetPaths, ALinkThatBreaksDuringTheUploadLeavesNothingBehind) {
    Rail rail;
    Request request = upload(FakeMachine::paths());
    request.id = 2;
    const RawMessage raw =
        make_raw(WireChannel::control, MessageType::request, encode(request), 0, 2);
    const auto header = encode_header(raw.header);
    Bytes bytes(header.begin(), header.end());
    bytes.insert(bytes.end(), raw.payload.begin(), raw.payload.end());
    for (const std::size_t cut : {std::size_t{1}, std::size_t{31}, std::size_t{32}, std::size_t{33},
                                  bytes.size() / 2, bytes.size() - 1}) {
        const auto alone = [&] { return rail.server->client_count() == 0; };
        ASSERT_TRUE(FakeSession::eventually(alone));  // the last one's hello has been forgotten
        {
            TestClient client(*rail.server);
            EXPECT_EQ(client.hello("broken off").role, Role::control);
            ASSERT_TRUE(client.stream().write_all(
                Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(cut)),
                Milliseconds(1000)));
        }
        ASSERT_TRUE(FakeSession::eventually(alone));
        TestClient next(*rail.server);
        ASSERT_EQ(next.hello("next").role, Role::control);
        EXPECT_NE(image_paths(next).find("none"), std::string::npos) << cut;
    }
    EXPECT_TRUE(rail.is_safe());
}

}  // namespace
}  // namespace stria

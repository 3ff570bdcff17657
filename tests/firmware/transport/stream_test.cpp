#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>

#include "firmware/transport/memory_stream.h"
#include "firmware/transport/socket.h"

namespace stria {
namespace {

using std::chrono::steady_clock;
constexpr Milliseconds kLong{5000};

std::string socket_path(const char* name) {
    return (std::filesystem::temp_directory_path() /
            ("stria_" + std::to_string(::getpid()) + "_" + name))
        .string();
}

struct Ends {
    std::unique_ptr<Listener> listener;
    std::unique_ptr<ByteStream> client, server;
};

Ends connected(const std::string& kind) {
    Ends ends;
    if (kind == "memory") {
        std::tie(ends.client, ends.server) = make_memory_streams();
        return ends;
    }
    const std::string address =
        kind == "unix" ? "unix:" + socket_path("ends") : std::string("tcp:127.0.0.1:0");
    auto listener = listen_socket(*parse_address(address));
    EXPECT_TRUE(listener) << listener.failure().message;
    ends.listener = std::move(*listener);
    auto client = connect_socket(ends.listener->address(), kLong);
    EXPECT_TRUE(client) << client.failure().message;
    ends.client = std::move(*client);
    auto server = ends.listener->accept(kLong);
    EXPECT_TRUE(server);
    ends.server = std::move(*server);
    return ends;
}

/// The same contract for every kind of stream.
class Stream : public testing::TestWithParam<const char*> {
  protected:
    void SetUp() override { ends_ = connected(GetParam()); }
    Ends ends_;
};

TEST_P(Stream, CarriesManyMessagesBothWaysAtOnce) {
    Bytes big(3 << 20);
    std::iota(big.begin(), big.end(), std::uint8_t{0});
    const auto send = [&](ByteStream& stream) {
        for (std::uint32_t i = 0; i < 5; ++i)
            ASSERT_TRUE(write_message(
                stream, make_raw(WireChannel::data, MessageType::frame, big, 1, i), kLong));
    };
    const auto receive = [&](ByteStream& stream) {
        for (std::uint32_t i = 0; i < 5; ++i) {
            auto read = read_message(stream, kLong);
            ASSERT_TRUE(read) << read.failure().message;
            ASSERT_TRUE(read->message);
            EXPECT_EQ(read->message->header.sequence, i);
            EXPECT_EQ(read->message->payload, big);
        }
    };
    std::thread a([&] { send(*ends_.client); }), b([&] { send(*ends_.server); });
    std::thread c([&] { receive(*ends_.client); });
    receive(*ends_.server);
    a.join();
    b.join();
    c.join();
}

TEST_P(Stream, ReadingNothingEndsInTime) {
    std::uint8_t byte = 0;
    const auto begin = steady_clock::now();
    const auto read = ends_.client->read_some({&byte, 1}, Milliseconds(50));
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->timed_out);
    EXPECT_FALSE(read->is_closed());
    EXPECT_GE(steady_clock::now() - begin, Milliseconds(45));
    EXPECT_LT(steady_clock::now() - begin, Milliseconds(2000));
}

TEST_P(Stream, WritingToOneThatDoesNotReadEndsInTime) {
    const Bytes much(64 << 20);
    const Status done = ends_.client->write_all(much, Milliseconds(50));
    EXPECT_FALSE(done);
}

TEST_P(Stream, SeesTheOtherEndClose) {
    ASSERT_TRUE(ends_.server->write_all(Bytes{7}, kLong));
    ends_.server.reset();
    std::uint8_t byte = 0;
    EXPECT_EQ(ends_.client->read_some({&byte, 1}, kLong)->bytes, 1U);  // what came before it
    EXPECT_TRUE(ends_.client->read_some({&byte, 1}, kLong)->is_closed());
    Status done;
    for (int i = 0; done && i < 100; ++i) done = ends_.client->write_all(Bytes(1 << 16), kLong);
    EXPECT_FALSE(done);
}

TEST_P(Stream, CloseWakesAReader) {
    std::thread closer([&] {
        std::this_thread::sleep_for(Milliseconds(30));
        ends_.client->close();
    });
    std::uint8_t byte = 0;
    const auto begin = steady_clock::now();
    const auto read = ends_.client->read_some({&byte, 1}, Milliseconds(20'000));
    EXPECT_TRUE(!read || read->is_closed());
    EXPECT_LT(steady_clock::now() - begin, Milliseconds(10'000));
    closer.join();
}

TEST_P(Stream, AMessageThatBreaksOffIsAFailure) {
    const RawMessage message = make_raw(WireChannel::data, MessageType::end, Bytes(100), 1, 0);
    const auto header = encode_header(message.header);
    ASSERT_TRUE(ends_.server->write_all(header, kLong));
    ASSERT_TRUE(ends_.server->write_all(Bytes(40), kLong));
    ends_.server.reset();
    const auto read = read_message(*ends_.client, kLong);
    ASSERT_FALSE(read);
    EXPECT_NE(read.failure().message.find("in the middle of a message"), std::string::npos);
}

TEST_P(Stream, RefusesBytesThatAreNoMessage) {
    ASSERT_TRUE(ends_.server->write_all(Bytes(64, 'x'), kLong));
    EXPECT_FALSE(read_message(*ends_.client, kLong));
}

INSTANTIATE_TEST_SUITE_P(Kinds, Stream, testing::Values("memory", "unix", "tcp"),
                         [](const auto& kind) { return std::string(kind.param); });

TEST(Socket, ConnectingWhereNothingListensSaysSo) {
    for (const std::string& text : {"unix:" + socket_path("nobody"), std::string("tcp:::1:1")}) {
        const auto stream = connect_socket(*parse_address(text), Milliseconds(500));
        ASSERT_FALSE(stream);
        EXPECT_NE(stream.failure().message.find("nothing listens there"), std::string::npos);
    }
}

TEST(Socket, AUnixSocketIsItsOwnersAndGoesWithItsListener) {
    const std::string path = socket_path("owner");
    {
        auto listener = listen_socket(*parse_address("unix:" + path));
        ASSERT_TRUE(listener);
        struct stat status {};
        ASSERT_EQ(::stat(path.c_str(), &status), 0);
        EXPECT_EQ(status.st_mode & 0077U, 0U);
    }
    EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Socket, DoesNotTakeAPathThatSomebodyUses) {
    const std::string path = socket_path("taken");
    auto first = listen_socket(*parse_address("unix:" + path));
    ASSERT_TRUE(first);
    const auto second = listen_socket(*parse_address("unix:" + path));
    ASSERT_FALSE(second);
    EXPECT_NE(second.failure().message.find("another server"), std::string::npos);
    first = Failure{};  // gone
    std::ofstream(path) << "a file";
    EXPECT_FALSE(listen_socket(*parse_address("unix:" + path)));
    std::filesystem::remove(path);
}

TEST(Socket, CloseWakesAccept) {
    auto listener = listen_socket(*parse_address("tcp:127.0.0.1:0"));
    ASSERT_TRUE(listener);
    std::thread closer([&] {
        std::this_thread::sleep_for(Milliseconds(30));
        (*listener)->close();
    });
    const auto begin = steady_clock::now();
    const auto none = (*listener)->accept(Milliseconds(20'000));
    EXPECT_TRUE(none && !*none);
    EXPECT_LT(steady_clock::now() - begin, Milliseconds(10'000));
    closer.join();
}

}  // namespace
}  // namespace stria

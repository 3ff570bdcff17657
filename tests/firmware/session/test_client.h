#pragma once
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "firmware/protocol/codec.h"
#include "firmware/session/device_server.h"
#include "firmware/transport/memory_stream.h"
#include "tests/firmware/acquire/fake_machine.h"

namespace stria {

/// Asks and reads on the test's own thread; what comes besides answers is kept.
class TestClient {
  public:
    explicit TestClient(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)) {}
    explicit TestClient(DeviceServer& server) {
        auto [there, here] = make_memory_streams();
        server.serve(std::move(there));
        stream_ = std::move(here);
    }

    void tell(Request request) {
        request.id = ++id_;
        ASSERT_TRUE(write_message(
            *stream_, make_raw(WireChannel::control, MessageType::request, encode(request), 0, id_),
            Milliseconds(5000)));
    }
    Response ask(const Request& request) {
        tell(request);
        Response response;
        response.ok = false;
        read_until([&](const RawMessage& raw) {
            if (raw.header.type != MessageType::response) return false;
            response = std::get<Response>(*decode(raw.header.type, raw.payload));
            return response.id == id_;
        });
        return response;
    }
    Response hello(const char* name, Role role = Role::control) {
        Request request;
        request.verb = RequestVerb::hello;
        request.client = name;
        request.role = role;
        return ask(request);
    }
    Response ask(RequestVerb verb) { return ask(Request{.verb = verb}); }
    Response start(const ScanPlan& plan) {
        return ask(Request{.verb = RequestVerb::start, .plan = plan});
    }
    void credit(std::uint64_t bytes) { tell({.verb = RequestVerb::credit, .credit_bytes = bytes}); }
    /// The end message of a run, after which `data` holds all of it.
    End read_to_end() {
        End end;
        read_until([&](const RawMessage& raw) {
            if (raw.header.type != MessageType::end) return false;
            end = std::get<End>(*decode(raw.header.type, raw.payload));
            return true;
        });
        return end;
    }
    /// Reads for a while; true if the server closed the connection.
    bool is_closed_within(Milliseconds time) {
        const auto end = std::chrono::steady_clock::now() + time;
        while (std::chrono::steady_clock::now() < end) {
            const auto read = read_message(*stream_, Milliseconds(20));
            if (!read || (!read->message && !read->timed_out)) return true;
        }
        return false;
    }
    /// False after 20 s, or if the connection broke.
    bool read_until(const std::function<bool(const RawMessage&)>& is_it) {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
        while (std::chrono::steady_clock::now() < end) {
            auto read = read_message(*stream_, Milliseconds(100));
            if (!read || (!read->message && !read->timed_out)) break;
            if (!read->message) continue;
            if (read->message->header.channel == WireChannel::data) data.push_back(*read->message);
            if (read->message->header.channel == WireChannel::health)
                health.push_back(
                    std::get<Health>(*decode(read->message->header.type, read->message->payload)));
            if (is_it(*read->message)) return true;
        }
        ADD_FAILURE() << "what was waited for did not come";
        return false;
    }
    ByteStream& stream() { return *stream_; }

    std::vector<RawMessage> data;
    std::vector<Health> health;

  private:
    std::unique_ptr<ByteStream> stream_;
    std::uint32_t id_ = 0;
};

/// A session on a fake machine whose frames each take `frame_time` of real time.
struct FakeSession {
    explicit FakeSession(ServerOptions options = {}, Milliseconds frame_time = Milliseconds(0),
                         bool moves_part = false) {
        machine.on_frame = [frame_time] { std::this_thread::sleep_for(frame_time); };
        ServedDevice device(machine.devices());
        device.model_name = "fake scanner";
        device.serial = "7";
        device.model_text = "# a model";
        device.acquire.spacetime_per_pixel = !moves_part;
        if (moves_part) device.kind = "rail";
        server = std::make_unique<DeviceServer>(device, options);
    }
    /// Waits up to 10 s.
    template <typename Condition>
    static bool eventually(Condition condition) {
        for (int i = 0; i < 1000 && !condition(); ++i)
            std::this_thread::sleep_for(Milliseconds(10));
        return condition();
    }
    bool is_safe() const { return !machine.laser_on && !machine.drive_on; }

    static ScanPlan plan() {
        ScanPlan plan;
        plan.mode = StripeMode::spatial;
        plan.from = 0.5;
        plan.to = 3.0;
        plan.step = 0.1;
        plan.off_frames = 1;
        plan.record = RecordWhat::both;
        return plan;
    }

    FakeMachine machine;
    std::unique_ptr<DeviceServer> server;
};

}  // namespace stria

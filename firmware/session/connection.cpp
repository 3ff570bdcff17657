#include "firmware/session/connection.h"

#include <algorithm>

#include "firmware/protocol/codec.h"

namespace stria {
namespace {

using SteadyClock = std::chrono::steady_clock;

SharedMessage shared(WireChannel channel, MessageType type, Bytes payload, std::uint32_t sequence) {
    return std::make_shared<const RawMessage>(
        make_raw(channel, type, std::move(payload), 0, sequence));
}

}  // namespace

Connection::Connection(std::unique_ptr<ByteStream> stream, ConnectionOwner& owner,
                       const ConnectionOptions& options)
    : stream_(std::move(stream)),
      owner_(owner),
      options_(options),
      outbox_(options.max_data_bytes) {}

Connection::~Connection() {
    close();
    if (reader_.joinable()) reader_.join();
    if (writer_.joinable()) writer_.join();
}

void Connection::start() {
    writer_ = std::thread([this] { write_messages(); });
    reader_ = std::thread([this] { read_requests(); });
}

void Connection::close() {
    closing_ = true;
    outbox_.close();
    stream_->close();
}

void Connection::send_health(const Health& health) {
    outbox_.put_urgent(
        shared(WireChannel::health, MessageType::health, encode(health), health_sequence_++));
}

void Connection::read_requests() {
    const std::string why = read_until_lost();
    owner_.lost(*this, why);
    close();
    outbox_.clear_data();
    finished_ = true;
}

std::string Connection::read_until_lost() {
    const Milliseconds turn = std::min(Milliseconds(50), options_.silence / 4);
    auto heard = SteadyClock::now();
    std::string why;
    while (true) {
        const auto read = read_message(*stream_, turn, options_.silence);
        if (closing_) return "the connection was closed";
        if (!read) return read.failure().message;
        if (read->message) {
            heard = SteadyClock::now();
            if (!take(*read->message, why)) return why;
        } else if (!read->timed_out) {
            return "the client closed its connection";
        }
        if (outbox_.is_closed()) return "the client does not read";
        if (SteadyClock::now() - heard > options_.silence)
            return "no heartbeat for " + std::to_string(options_.silence.count()) + " ms";
    }
}

/// False, and why, if the client must go.
bool Connection::take(const RawMessage& raw, std::string& why) {
    if (raw.header.type != MessageType::request) {
        why = "the client sent something that is no request";
        return false;
    }
    const auto message = decode(raw.header.type, raw.payload);
    Response response;
    if (message) {
        const Request& request = std::get<Request>(*message);
        if (request.verb == RequestVerb::credit) {
            outbox_.add_credit(request.credit_bytes);
            return true;
        }
        response = owner_.answer(*this, request);
        response.id = request.id;
    } else {
        response.id = request_id(raw.payload).value_or(0);
        response.ok = false;
        response.error = message.failure().message;
    }
    outbox_.put_urgent(
        shared(WireChannel::control, MessageType::response, encode(response), control_sequence_++));
    return true;
}

void Connection::write_messages() {
    while (true) {
        const SharedMessage message = outbox_.next(Milliseconds(200));
        if (message) {
            if (write_message(*stream_, *message, options_.write_timeout)) continue;
            close();
            return;
        }
        if (outbox_.is_closed()) return;
    }
}

}  // namespace stria

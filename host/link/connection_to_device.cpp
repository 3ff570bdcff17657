#include "host/link/connection_to_device.h"

#include <algorithm>

#include "firmware/protocol/codec.h"
#include "host/core/errors.h"

namespace stria {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr std::uint32_t kHeartbeatId = 0;  // its responses only show that the device lives

}  // namespace

ConnectionToDevice::ConnectionToDevice(std::unique_ptr<ByteStream> stream,
                                       std::chrono::milliseconds timeout)
    : stream_(std::move(stream)), timeout_(timeout), reader_([this] { read_messages(); }) {}

ConnectionToDevice::~ConnectionToDevice() {
    closing_ = true;
    stream_->close();
    reader_.join();
}

void ConnectionToDevice::send(const Request& request) {
    const std::lock_guard lock(writing_);
    const Status done = write_message(
        *stream_,
        make_raw(WireChannel::control, MessageType::request, encode(request), 0, sequence_++),
        timeout_);
    if (!done) throw DeviceError(done.failure().message);
}

void ConnectionToDevice::tell(Request request) {
    request.id = kHeartbeatId;
    send(request);
}

Response ConnectionToDevice::ask(Request request) {
    {
        const std::lock_guard lock(mutex_);
        request.id = next_id_++;
    }
    send(request);
    std::unique_lock lock(mutex_);
    const bool came = changed_.wait_for(
        lock, timeout_, [&] { return responses_.count(request.id) > 0 || !broken_.empty(); });
    const auto found = responses_.find(request.id);
    if (found != responses_.end()) {
        Response response = std::move(found->second);
        responses_.erase(found);
        return response;
    }
    if (came) throw DeviceError(broken_);
    throw DeviceError(stream_->name() + ": the device did not answer within " +
                      std::to_string(timeout_.count()) + " ms");
}

Response ConnectionToDevice::demand(Request request) {
    Response response = ask(std::move(request));
    if (!response.ok) throw DeviceError(stream_->name() + ": " + response.error);
    return response;
}

std::optional<RawMessage> ConnectionToDevice::next_data(std::chrono::milliseconds wait) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, wait, [&] { return !data_.empty() || !broken_.empty(); });
    if (!data_.empty()) {
        RawMessage message = std::move(data_.front());
        data_.pop_front();
        return message;
    }
    if (!broken_.empty()) throw DeviceError(broken_);
    return std::nullopt;
}

void ConnectionToDevice::drop_data() {
    const std::lock_guard lock(mutex_);
    data_.clear();
}

std::optional<Health> ConnectionToDevice::last_health() const {
    const std::lock_guard lock(mutex_);
    return health_;
}

void ConnectionToDevice::read_messages() {
    const std::string why = read_until_broken();
    const std::lock_guard lock(mutex_);
    broken_ = why;
    changed_.notify_all();
}

bool ConnectionToDevice::send_heartbeat() {
    Request request;
    request.verb = RequestVerb::heartbeat;
    try {
        tell(request);
    } catch (const DeviceError&) {
        return false;
    }
    return true;
}

std::string ConnectionToDevice::read_until_broken() {
    const auto beat =
        std::clamp(timeout_ / 5, std::chrono::milliseconds(20), std::chrono::milliseconds(1000));
    auto heard = SteadyClock::now(), sent = heard;
    while (!closing_) {
        if (SteadyClock::now() - sent >= beat) {
            if (!send_heartbeat()) return stream_->name() + ": the device closed the connection";
            sent = SteadyClock::now();
        }
        auto read = read_message(*stream_, beat / 2, timeout_);
        if (closing_) break;
        if (!read) return read.failure().message;
        if (read->message) {
            heard = SteadyClock::now();
            take(std::move(*read->message));
        } else if (!read->timed_out) {
            return stream_->name() + ": the device closed the connection";
        }
        if (SteadyClock::now() - heard > timeout_)
            return stream_->name() + ": the device was silent for " +
                   std::to_string(timeout_.count()) + " ms";
    }
    return stream_->name() + ": closed";
}

void ConnectionToDevice::take(RawMessage raw) {
    const std::lock_guard lock(mutex_);
    if (raw.header.channel == WireChannel::data) {
        data_.push_back(std::move(raw));
    } else {
        auto message = decode(raw.header.type, raw.payload);
        if (!message) return;  // whoever waits for it says that nothing came
        if (auto* response = std::get_if<Response>(&*message)) {
            if (response->id != kHeartbeatId) responses_[response->id] = std::move(*response);
        } else if (auto* health = std::get_if<Health>(&*message)) {
            health_ = std::move(*health);
        }
    }
    changed_.notify_all();
}

}  // namespace stria

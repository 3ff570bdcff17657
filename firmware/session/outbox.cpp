#include "firmware/session/outbox.h"

#include <algorithm>
#include <limits>

namespace stria {
namespace {
constexpr std::size_t kMaxUrgent = 1000;
}

bool Outbox::put_urgent(SharedMessage message) {
    const std::lock_guard lock(mutex_);
    if (urgent_.size() >= kMaxUrgent) closed_ = true;
    if (!closed_) urgent_.push_back(std::move(message));
    changed_.notify_all();
    return !closed_;
}

Outbox::Put Outbox::put_data(SharedMessage message, Milliseconds patience) {
    std::unique_lock lock(mutex_);
    const std::size_t size = size_of(message);
    const auto has_room = [&] {
        return closed_ || data_.empty() || data_bytes_ + size <= max_data_bytes_;
    };
    if (!changed_.wait_for(lock, patience, has_room)) return Put::full;
    if (closed_) return Put::closed;
    data_.push_back(std::move(message));
    data_bytes_ += size;
    changed_.notify_all();
    return Put::done;
}

void Outbox::add_credit(std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    credit_ += std::min(bytes, std::numeric_limits<std::uint64_t>::max() - credit_);
    changed_.notify_all();
}

SharedMessage Outbox::next(Milliseconds timeout) {
    std::unique_lock lock(mutex_);
    const auto has_some = [&] {
        return closed_ || !urgent_.empty() || (!data_.empty() && credit_ > 0);
    };
    changed_.wait_for(lock, timeout, has_some);
    SharedMessage message;
    if (!urgent_.empty()) {
        message = std::move(urgent_.front());
        urgent_.pop_front();
    } else if (!closed_ && !data_.empty() && credit_ > 0) {
        message = std::move(data_.front());
        data_.pop_front();
        const std::size_t size = size_of(message);
        data_bytes_ -= size;
        credit_ -= std::min<std::uint64_t>(credit_, size);
        changed_.notify_all();
    }
    return message;
}

void Outbox::clear_data() {
    const std::lock_guard lock(mutex_);
    data_.clear();
    data_bytes_ = 0;
    credit_ = 0;
    changed_.notify_all();
}

void Outbox::close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
}

bool Outbox::is_closed() const {
    const std::lock_guard lock(mutex_);
    return closed_;
}

}  // namespace stria

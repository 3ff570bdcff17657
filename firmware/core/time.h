#pragma once
#include <cstdint>

namespace stria {

/// A point on the device's monotonic clock, or a span of it, in nanoseconds.
using TimeNs = std::int64_t;

constexpr TimeNs kNsPerUs = 1'000;
constexpr TimeNs kNsPerMs = 1'000'000;
constexpr TimeNs kNsPerSecond = 1'000'000'000;

}  // namespace stria

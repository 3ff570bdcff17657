#pragma once
#include <string>

#include "firmware/protocol/framing.h"
#include "firmware/protocol/messages.h"

namespace stria {

constexpr std::size_t kMaxFeatures = 1000;
constexpr std::size_t kMaxText = 4096;                       ///< bytes of a name or sentence
constexpr std::size_t kMaxModelText = std::size_t{4} << 20;  ///< bytes of a scanner model
constexpr int kMaxMapWidth = 1'000'000;  ///< frames of a sweep, as a plan allows
constexpr std::int64_t kMaxMapCells = std::int64_t{1} << 26;

/// Empty if the message may be used as it stands, else field, value and bound: numbers finite,
/// enumerations known, sizes within bounds and equal to what width x height says.
std::string validate(const Feature& feature);
std::string validate(const DeviceDescription& device);
std::string validate(const Snapshot& snapshot);
std::string validate(const Frame& frame);
std::string validate(const AxisLog& log);
std::string validate(const PulseBand& band);
std::string validate(const Health& health);
std::string validate(const End& end);
std::string validate(const Request& request);
std::string validate(const Response& response);

}  // namespace stria

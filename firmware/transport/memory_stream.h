#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "firmware/protocol/byte_stream.h"

namespace stria {

using StreamPair = std::pair<std::unique_ptr<ByteStream>, std::unique_ptr<ByteStream>>;

/// Two ends of a connection inside this process. Each direction holds at most `capacity` bytes; a
/// writer waits while it is full.
StreamPair make_memory_streams(const std::string& name = "memory",
                               std::size_t capacity = std::size_t{4} << 20);

}  // namespace stria

#pragma once
#include <memory>

#include "firmware/protocol/byte_stream.h"
#include "host/link/device_client.h"

namespace stria {

/// A client that speaks the protocol over a stream which is connected already. Says hello at once;
/// throws DeviceError if that is not answered in time.
std::unique_ptr<DeviceClient> make_link_client(std::unique_ptr<ByteStream> stream,
                                               const ConnectOptions& options = {});

/// A recording as a device: its features can be read, a run returns what was recorded.
std::unique_ptr<DeviceClient> make_replay_client(const std::string& path);

}  // namespace stria

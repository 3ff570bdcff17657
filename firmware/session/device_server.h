#pragma once
#include <memory>
#include <string>

#include "firmware/protocol/byte_stream.h"
#include "firmware/session/served_device.h"

namespace stria {

struct ServerOptions {
    Milliseconds heartbeat_timeout{5000};  ///< a silent client is lost; a run of its ends
    Milliseconds data_stall{10'000};       ///< a run ends when its client takes no data for so long
    std::size_t max_data_bytes = std::size_t{64} << 20;  ///< waiting for one client
    /// Folder where each run is kept as a recording until its client acknowledges that it is safe
    /// on its own disk; empty: nothing is kept.
    std::string spool_folder = {};
};

/// Serves one machine to any number of clients over any ByteStreams. The first that asks for it
/// controls, the others watch; every one may stop a run. A run ends in the safe state when it is
/// done, is stopped, its client's heartbeat is lost or the server is destroyed.
///
/// Threads: one runs the machine; each client has one that reads and one that writes.
class DeviceServer {
  public:
    DeviceServer(ServedDevice device, const ServerOptions& options = {});
    ~DeviceServer();
    DeviceServer(const DeviceServer&) = delete;
    DeviceServer& operator=(const DeviceServer&) = delete;

    /// Takes a client; returns at once.
    void serve(std::unique_ptr<ByteStream> stream);
    /// Clients at present.
    std::size_t client_count() const;
    bool is_running() const;

  private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace stria

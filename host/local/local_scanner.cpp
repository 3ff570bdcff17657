#include "host/local/local_scanner.h"

#include <algorithm>

#include "firmware/session/device_server.h"
#include "firmware/transport/memory_stream.h"
#include "host/link/link_client.h"
#include "sim/striad_sim/served_scanner.h"

namespace stria {
namespace {

// Both ends live and die together, so silence only means that the computer is busy.
constexpr std::chrono::milliseconds kPatience{60'000};

}  // namespace

struct LocalScanner::Parts {
    Parts(const Scene& scene, const OpenOptions& options)
        : scanner(scene, options.seed),
          server(served_scanner(scanner, options.threads),
                 {.heartbeat_timeout = kPatience, .data_stall = 10 * kPatience}) {
        auto [there, here] = make_memory_streams("sim");
        server.serve(std::move(there));
        ConnectOptions connect = options.connect;
        connect.timeout = std::max(connect.timeout, kPatience);
        client = make_link_client(std::move(here), connect);
    }
    SimulatedScanner scanner;
    DeviceServer server;  // before the scanner it borrows goes
    std::unique_ptr<DeviceClient> client;
};

LocalScanner::LocalScanner(const Scene& scene, const OpenOptions& options)
    : parts_(std::make_unique<Parts>(scene, options)) {}
LocalScanner::~LocalScanner() = default;

Snapshot LocalScanner::info() { return parts_->client->info(); }
std::vector<Feature> LocalScanner::features() { return parts_->client->features(); }
Feature LocalScanner::feature(const std::string& name) { return parts_->client->feature(name); }
Feature LocalScanner::set_feature(const std::string& name, const FeatureValue& value) {
    return parts_->client->set_feature(name, value);
}
void LocalScanner::set_paths(const std::vector<PathTable>& tables) {
    parts_->client->set_paths(tables);
}
RecordingContents LocalScanner::run(const ScanPlan& plan, const RunOptions& options) {
    return parts_->client->run(plan, options);
}
SimulatedScanner& LocalScanner::scanner() { return parts_->scanner; }

std::unique_ptr<DeviceClient> open_device(const std::string& uri, const OpenOptions& options) {
    if (!uri.starts_with("sim:")) return connect_device(uri, options.connect);
    const std::string path = uri.substr(4);
    return std::make_unique<LocalScanner>(path.empty() ? built_in_scene() : read_scene(path),
                                          options);
}

}  // namespace stria

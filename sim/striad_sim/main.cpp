// striad-sim: a simulated scanner as a server that speaks the device's own protocol.
//
// Threads, what each owns and the queues between them:
// - main: the listeners; accepts clients and hands their streams to the session.
// - machine (DeviceServer): the simulated devices during a run; fills the clients' outboxes.
// - one reader a client (Connection): its requests; answers go into its outbox.
// - one writer a client (Connection): empties its outbox into the stream.
// - stripe analysis: the analysers' own, joined before their calls return.
#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "firmware/session/device_server.h"
#include "firmware/session/feature_table.h"
#include "firmware/transport/socket.h"
#include "sim/striad_sim/served_scanner.h"

namespace stria {
namespace {

std::atomic<bool> g_stop = false;  // set by a signal handler, which can reach nothing else
static_assert(std::atomic<bool>::is_always_lock_free);

struct Settings {
    std::string scene;
    std::vector<std::string> listen;
    unsigned seed = 1;
    int threads = 1;
    std::string spool;
    bool fast = false;
    bool quiet = false;
};

using Listeners = std::vector<std::unique_ptr<Listener>>;

Listeners open_listeners(const std::vector<std::string>& addresses) {
    Listeners listeners;
    for (const std::string& text : addresses) {
        const auto address = parse_address(text);
        if (!address) throw std::runtime_error("--listen " + address.failure().message);
        auto listener = listen_socket(*address);
        if (!listener) throw std::runtime_error("--listen " + listener.failure().message);
        listeners.push_back(std::move(*listener));
    }
    return listeners;
}

ServedDevice served(SimulatedScanner& scanner, const Settings& settings) {
    ServedDevice device = served_scanner(scanner, settings.threads);
    device.acquire.spacetime.fast = settings.fast;
    if (!settings.fast) return device;
    const std::string why_not = why_not_fast(device.devices.camera.info(), device.acquire);
    if (!why_not.empty()) throw std::runtime_error("--fast: " + why_not);
    return device;
}

void serve_until_stopped(const Settings& settings) {
    SimulatedScanner scanner(read_scene(settings.scene), settings.seed);
    const Listeners listeners = open_listeners(settings.listen);
    DeviceServer server(served(scanner, settings), {.spool_folder = settings.spool});
    if (!settings.quiet) {
        for (const auto& listener : listeners)
            std::printf("listening on %s\n", to_string(listener->address()).c_str());
        std::fflush(stdout);
    }
    const Milliseconds turn(200 / static_cast<int>(listeners.size()));
    while (!g_stop) {
        for (const auto& listener : listeners) {
            auto client = listener->accept(turn);
            if (!client) throw std::runtime_error(client.failure().message);
            if (*client) server.serve(std::move(*client));
        }
    }
}

}  // namespace
}  // namespace stria

int main(int argc, char** argv) {
    stria::Settings settings;
    CLI::App app("Serves a simulated scanner, made from a scene, over the device's protocol.",
                 "striad-sim");
    app.set_version_flag("--version", STRIA_VERSION);
    app.add_option("SCENE", settings.scene, "scene.toml")->required();
    app.add_option("--listen", settings.listen,
                   "unix:PATH or tcp:127.0.0.1:PORT (port 0: any); may be repeated")
        ->required();
    app.add_option("--seed", settings.seed, "of the noise, mixed with the scene's own");
    app.add_option("--threads", settings.threads, "for the stripe analysis")
        ->check(CLI::Range(1, 256));
    app.add_option("--spool", settings.spool,
                   "folder that keeps each run until its client has it safe")
        ->check(CLI::ExistingDirectory);
    app.add_flag("--fast", settings.fast,
                 "start with the feature FastSpacetime set: SIMD kernels analyse sweeps");
    app.add_flag("--quiet", settings.quiet, "say nothing but errors");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : 2;
    }
    const auto on_signal = [](int) { stria::g_stop = true; };
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    try {
        stria::serve_until_stopped(settings);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "striad-sim: %s\n", error.what());
        return 1;
    }
}

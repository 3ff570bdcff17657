#include "host/cli/describe_device.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/link/device_client.h"
#include "host/link/discover.h"

namespace stria {
namespace {

constexpr std::chrono::milliseconds kPatience{1000};  // a server on this computer answers at once

class DevicesVerb final : public Verb {
  public:
    std::string name() const override { return "devices"; }
    std::string summary() const override { return "find devices on this computer"; }
    void declare(Arguments& arguments) override {
        arguments.positional("DEVICE", devices_,
                             "further devices to ask: unix:PATH, tcp:HOST:PORT or replay:FILE",
                             false);
    }

    int run(const Context& context) override {
        std::vector<JsonResult> results;
        context.say("sim:  the built-in simulated scanner; sim:SCENE.toml is one of your own");
        results.push_back(
            JsonResult().set("device", "sim:").set("answers", true).set("simulated", true));
        std::vector<std::string> uris = find_sockets(socket_folders());
        uris.insert(uris.end(), devices_.begin(), devices_.end());
        for (const std::string& uri : uris) results.push_back(ask(context, uri));
        if (uris.empty()) {
            std::string searched;
            for (const std::string& folder : socket_folders())
                searched += (searched.empty() ? "" : " and ") + folder;
            context.say("no scanner's socket in " + searched);
        }
        context.finish(JsonResult().set("devices", results));
        return 0;
    }

  private:
    static JsonResult ask(const Context& context, const std::string& uri) {
        JsonResult result;
        result.set("device", uri);
        try {
            const auto client = connect_device(uri, {.control = false, .timeout = kPatience});
            const DeviceDescription device = client->info().device;
            context.say(uri + "  " + device.model_name + ", " + device.kind + ", serial " +
                        device.serial);
            result.set("answers", true)
                .set("model_name", device.model_name)
                .set("serial", device.serial)
                .set("kind", device.kind)
                .set("simulated", device.simulated);
        } catch (const Error& error) {
            context.say(uri + "  does not answer: " + error.what());
            result.set("answers", false).set("error", error.what());
        }
        return result;
    }

    std::vector<std::string> devices_;
};

}  // namespace

std::unique_ptr<Verb> make_devices_verb() { return std::make_unique<DevicesVerb>(); }

}  // namespace stria

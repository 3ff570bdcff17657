#include "host/cli/describe_device.h"
#include "host/cli/verbs.h"
#include "host/local/open_device.h"

namespace stria {
namespace {

class FeaturesVerb final : public Verb {
  public:
    std::string name() const override { return "features"; }
    std::string summary() const override { return "read and set a device's features"; }
    void declare(Arguments& arguments) override {
        arguments.positional("DEVICE", device_,
                             "sim:SCENE.toml, unix:PATH, tcp:HOST:PORT or replay:FILE");
        arguments.positional("NAME", wanted_, "NAME to read, NAME=VALUE to set; without: all",
                             false);
    }

    int run(const Context& context) override {
        OpenOptions options{.connect = {}, .seed = context.seed};
        options.connect.control = sets_one();
        const auto device = open_device(device_, options);
        std::vector<Feature> features;
        for (const std::string& wanted : wanted_) features.push_back(one(*device, wanted));
        if (wanted_.empty()) features = device->features();

        std::vector<JsonResult> results;
        for (const Feature& feature : features) {
            context.say(line_of(feature));
            results.push_back(json_of(feature));
        }
        context.finish(JsonResult().set("features", results));
        return 0;
    }

  private:
    bool sets_one() const {
        for (const std::string& wanted : wanted_)
            if (wanted.find('=') != std::string::npos) return true;
        return false;
    }

    static Feature one(DeviceClient& device, const std::string& wanted) {
        const std::size_t equals = wanted.find('=');
        const Feature feature = device.feature(wanted.substr(0, equals));
        if (equals == std::string::npos) return feature;
        return device.set_feature(feature.name,
                                  parse_feature_value(feature, wanted.substr(equals + 1)));
    }

    std::string device_;
    std::vector<std::string> wanted_;
};

}  // namespace

std::unique_ptr<Verb> make_features_verb() { return std::make_unique<FeaturesVerb>(); }

}  // namespace stria

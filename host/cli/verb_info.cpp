#include <sstream>

#include "host/cli/describe_device.h"
#include "host/cli/verbs.h"
#include "host/local/open_device.h"

namespace stria {
namespace {

std::string text_of(const Snapshot& info) {
    const DeviceDescription& d = info.device;
    const std::string unit = d.kind == "rail" ? "mm" : "rad";
    std::ostringstream text;
    text << d.model_name << " (" << d.kind << (d.simulated ? ", simulated" : "") << "), serial "
         << d.serial << ", firmware " << d.firmware_version << ", protocol "
         << info.protocol_version << "\n"
         << "camera: " << d.camera_name << ", " << d.width << " x " << d.height << " px, " << d.bits
         << " bit, at most " << 1e9 / static_cast<double>(d.min_frame_period_ns) << " frames/s, "
         << (d.row_time_ns == 0 ? std::string("global shutter")
                                : "row time " + std::to_string(d.row_time_ns) + " ns")
         << "\n"
         << "axis:   " << d.axis_name << ", " << d.axis_min << " to " << d.axis_max << " " << unit
         << ", at most " << d.axis_max_speed << " " << unit << "/s, sigma " << d.axis_sigma << " "
         << unit << "\n"
         << "lasers: " << d.lasers << "\n"
         << "model:  "
         << (info.model_text.empty() ? "none stated"
                                     : "nominal model stated; calibrate before measuring");
    return text.str();
}

class InfoVerb final : public Verb {
  public:
    std::string name() const override { return "info"; }
    std::string summary() const override { return "what a device is"; }
    void declare(Arguments& arguments) override {
        arguments.positional("DEVICE", device_,
                             "sim:SCENE.toml, unix:PATH, tcp:HOST:PORT or replay:FILE");
    }
    int run(const Context& context) override {
        OpenOptions options{.connect = {}, .seed = context.seed};
        options.connect.control = false;
        const Snapshot info = open_device(device_, options)->info();
        context.say(text_of(info));
        JsonResult result = json_of(info.device);
        result.set("protocol_version", info.protocol_version)
            .set("clock_ns", static_cast<double>(info.clock_ns))
            .set("nominal_model", info.model_text);
        if (device_.starts_with("replay:")) result.set("plan", json_of(info.plan));
        context.finish(result);
        return 0;
    }

  private:
    std::string device_;
};

}  // namespace

std::unique_ptr<Verb> make_info_verb() { return std::make_unique<InfoVerb>(); }

}  // namespace stria

#include "host/link/link_client.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "firmware/protocol/codec.h"
#include "firmware/protocol/recording.h"
#include "host/core/errors.h"
#include "host/link/connection_to_device.h"

namespace stria {
namespace {

constexpr std::uint64_t kCredit = std::uint64_t{64} << 20;  // bytes of data on their way at most
constexpr std::chrono::milliseconds kTurn{100};

void expect(const Status& status) {
    if (!status) throw Error(status.failure().message);
}

std::uint32_t frames_of(const ScanPlan& plan) {
    const double a_pass = (plan.to - plan.from) / plan.step * (1 + 1e-9);
    const std::size_t exposures = std::max<std::size_t>(1, plan.exposures_us.size());
    const std::size_t passes = plan.lasers.size() * exposures * (plan.both_directions ? 2 : 1);
    return static_cast<std::uint32_t>(passes) * (static_cast<std::uint32_t>(a_pass) + 1);
}

class LinkClient : public DeviceClient {
  public:
    LinkClient(std::unique_ptr<ByteStream> stream, const ConnectOptions& options)
        : device_(std::move(stream), options.timeout) {
        Request hello;
        hello.verb = RequestVerb::hello;
        hello.client = options.client_name;
        hello.role = options.control ? Role::control : Role::watch;
        device_.demand(hello);
    }

    Snapshot info() override {
        Response response = device_.demand({.verb = RequestVerb::describe});
        if (!response.snapshot) throw DeviceError(device_.name() + ": it did not describe itself");
        return std::move(*response.snapshot);
    }

    std::vector<Feature> features() override {
        return device_.demand({.verb = RequestVerb::features}).features;
    }

    Feature feature(const std::string& name) override {
        return only(device_.demand({.verb = RequestVerb::features, .name = name}), name);
    }

    Feature set_feature(const std::string& name, const FeatureValue& value) override {
        return only(
            device_.demand({.verb = RequestVerb::set_feature, .name = name, .value = value}), name);
    }

    void set_paths(const std::vector<PathTable>& tables) override {
        const std::vector<Feature> known = features();
        const bool takes_paths = std::any_of(
            known.begin(), known.end(), [](const Feature& f) { return f.name == "ImagePaths"; });
        if (!takes_paths)
            throw DeviceError(device_.name() +
                              ": its firmware is older than image paths and takes none");
        for (const PathTable& table : tables)
            if (const std::string wrong = validate(table); !wrong.empty())
                throw std::invalid_argument("set_paths: " + wrong);
        device_.demand({.verb = RequestVerb::set_paths});
        for (const PathTable& table : tables)
            device_.demand({.verb = RequestVerb::set_paths, .paths = table});
    }

    RecordingContents run(const ScanPlan& plan, const RunOptions& options) override {
        device_.drop_data();
        device_.demand({.verb = RequestVerb::select, .channels = kSelectData | kSelectHealth});
        std::optional<RecordingWriter> recording;
        if (!options.recording_path.empty()) {
            auto created = RecordingWriter::create_raw(options.recording_path);
            if (!created) throw Error(created.failure().message);
            recording = std::move(*created);
        }
        const std::uint32_t run = device_.demand({.verb = RequestVerb::start, .plan = plan}).run;
        try {
            RecordingContents contents = receive(run, plan, options, recording);
            if (recording) expect(recording->close());
            device_.demand({.verb = RequestVerb::ack, .run = run});
            return contents;
        } catch (...) {
            give_up(recording);
            throw;
        }
    }

  private:
    Feature only(Response response, const std::string& name) const {
        if (response.features.size() == 1) return std::move(response.features.front());
        throw DeviceError(device_.name() + ": it did not tell the feature " + name);
    }

    RecordingContents receive(std::uint32_t run, const ScanPlan& plan, const RunOptions& options,
                              std::optional<RecordingWriter>& recording) {
        ContentsBuilder builder(device_.name(), options.load);
        std::vector<std::string> notes;
        grant(kCredit);
        std::uint32_t expected = 0;
        while (true) {
            auto raw = device_.next_data(kTurn);
            report(plan, options);
            if (!raw || raw->header.session != run) continue;
            if (raw->header.sequence != expected)
                throw DeviceError(device_.name() + ": data message " + std::to_string(expected) +
                                  " is missing");
            ++expected;
            if (recording) expect(recording->write_raw(*raw));
            auto message = decode(raw->header.type, raw->payload);
            if (!message) throw DeviceError(device_.name() + ": " + message.failure().message);
            const bool is_end = std::holds_alternative<End>(*message);
            builder.add(std::move(*message));
            if (is_end) return builder.finish();
            grant(kHeaderBytes + raw->payload.size());
        }
    }

    /// A link that broke is noticed by next_data(), after what had come before.
    void grant(std::uint64_t bytes) {
        try {
            device_.tell({.verb = RequestVerb::credit, .credit_bytes = bytes});
        } catch (const DeviceError&) {
            return;
        }
    }

    void report(const ScanPlan& plan, const RunOptions& options) const {
        if (!options.progress) return;
        const auto health = device_.last_health();
        if (!health) return;
        options.progress(
            {health->frames, frames_of(plan), health->frames_dropped, health->laser_on});
    }

    /// After a failure on this side: the device stops, the recording keeps what came.
    void give_up(std::optional<RecordingWriter>& recording) noexcept {
        try {
            if (recording) expect(recording->close());
            device_.demand({.verb = RequestVerb::select, .channels = kSelectHealth});
            device_.demand({.verb = RequestVerb::stop});
        } catch (const Error&) {
            return;  // the first failure is the one to tell
        }
    }

    mutable ConnectionToDevice device_;
};

}  // namespace

std::unique_ptr<DeviceClient> make_link_client(std::unique_ptr<ByteStream> stream,
                                               const ConnectOptions& options) {
    return std::make_unique<LinkClient>(std::move(stream), options);
}

}  // namespace stria

#include "firmware/protocol/codec.h"
#include "firmware/protocol/recording.h"
#include "host/core/errors.h"
#include "host/link/link_client.h"

namespace stria {
namespace {

class ReplayClient : public DeviceClient {
  public:
    explicit ReplayClient(std::string path) : path_(std::move(path)), snapshot_(first()) {}

    Snapshot info() override { return snapshot_; }
    std::vector<Feature> features() override { return snapshot_.features; }

    Feature feature(const std::string& name) override {
        for (const Feature& feature : snapshot_.features)
            if (feature.name == name) return feature;
        throw DeviceError(path_ + ": the recording has no feature \"" + name + "\"");
    }

    Feature set_feature(const std::string& name, const FeatureValue&) override {
        throw DeviceError(path_ + ": " + name + " cannot be set: a recording can only be read");
    }

    /// A recording was made along its own paths; run() notes where others are asked for.
    void set_paths(const std::vector<PathTable>& tables) override { asked_paths_ = tables; }

    RecordingContents run(const ScanPlan& plan, const RunOptions& options) override {
        if (!options.recording_path.empty()) copy(options.recording_path);
        LoadOptions load = options.load;
        RecordingContents contents = load_recording(path_, load);
        if (encode(asked_for(plan)) != encode(asked_for(snapshot_.plan)))
            contents.notes.push_back("the recording was made with another plan than asked for");
        if (!asked_paths_.empty() && !contents.path_tables.empty() &&
            asked_paths_ != contents.path_tables)
            contents.notes.push_back("the recording was made along other image paths than asked");
        return contents;
    }

  private:
    Snapshot first() const {
        const auto reader = RecordingReader::open(path_);
        if (!reader) throw Error(reader.failure().message);
        Snapshot snapshot = reader->snapshot();
        for (Feature& feature : snapshot.features) feature.access = Access::read;
        return snapshot;
    }

    static Snapshot asked_for(const ScanPlan& plan) {
        Snapshot snapshot;
        snapshot.plan = plan;
        return snapshot;
    }

    void copy(const std::string& to) const {
        auto reader = RecordingReader::open(path_);
        auto writer = RecordingWriter::create_raw(to);
        if (!reader || !writer)
            throw Error((!reader ? reader.failure() : writer.failure()).message);
        Status done = writer->write_raw(reader->snapshot_message());
        while (done) {
            auto raw = reader->next_raw();
            if (!raw) throw Error(raw.failure().message);
            if (!*raw) break;
            done = writer->write_raw(**raw);
        }
        if (done) done = writer->close();
        if (!done) throw Error(done.failure().message);
    }

    std::string path_;
    Snapshot snapshot_;
    std::vector<PathTable> asked_paths_;
};

}  // namespace

std::unique_ptr<DeviceClient> make_replay_client(const std::string& path) {
    return std::make_unique<ReplayClient>(path);
}

}  // namespace stria

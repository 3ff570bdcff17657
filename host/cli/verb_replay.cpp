#include <filesystem>

#include "host/cli/progress.h"
#include "host/cli/recording_range.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/local/open_device.h"

namespace stria {
namespace {

namespace fs = std::filesystem;

struct ModelChoice {
    ScannerModel model;
    std::string from;  ///< for people
};

class ReplayVerb final : public Verb {
  public:
    std::string name() const override { return "replay"; }
    std::string summary() const override {
        return "a recording once more: what scan would have written";
    }
    void declare(Arguments& arguments) override {
        arguments.positional("FILE", file_, "recording.stria");
        arguments.option("--out", out_,
                         "folder for recording.stria and range.ply; made if it does not exist",
                         true);
        arguments.option("--model", model_,
                         "calibrated scanner; without it the scanner.toml of the recording's "
                         "project, else the nominal model that the device stated");
    }

    int run(const Context& context) override {
        const auto device = open_device("replay:" + file_);
        const Snapshot info = device->info();
        const ModelChoice choice = choose_model(info);
        const std::string recording = out_ + "/recording.stria", range = out_ + "/range.ply";
        context.check_output(recording);
        context.check_output(range);
        make_folder();

        const RecordingContents contents = play(context, *device, info.plan, recording);
        for (const std::string& note : contents.notes) context.say(file_ + ": " + note);
        if (const std::string note = paths_note(contents, choice.model); !note.empty())
            context.say(file_ + ": " + note);
        context.say("model: " + choice.from);
        const RangeResult result = range_of(contents, choice.model, file_);
        write_range_image(range, result.image);
        context.say(range + ": " + describe(result.statistics));
        for (const std::string& note : result.notes) context.say(range + ": " + note);
        context.finish(JsonResult()
                           .set("recording", recording)
                           .set("range", range)
                           .set("model", choice.from)
                           .set("complete", contents.end && contents.end->complete)
                           .set("notes", contents.notes)
                           .set("points", result.statistics.points)
                           .set("median_sigma_mm", result.statistics.median_sigma_mm));
        return 0;
    }

  private:
    /// part/scans/0001/recording.stria belongs to part/scanner.toml.
    ModelChoice choose_model(const Snapshot& info) const {
        if (!model_.empty()) return {read_scanner(model_), model_};
        const fs::path part = fs::absolute(file_).parent_path().parent_path().parent_path();
        const std::string kept = (part / "scanner.toml").string();
        if (fs::exists(part / "project.toml") && fs::exists(kept))
            return {read_scanner(kept), kept};
        if (info.model_text.empty())
            throw Error(file_ + ": the device stated no model: expected --model scanner.toml");
        return {parse_scanner(info.model_text, file_ + " (its nominal model)"),
                "the device's nominal one, not calibrated"};
    }

    void make_folder() const {
        std::error_code error;
        fs::create_directories(out_, error);
        if (error) throw FileError(out_, "", "cannot be made: " + error.message());
    }

    RecordingContents play(const Context& context, DeviceClient& device, const ScanPlan& plan,
                           const std::string& recording) const {
        constexpr std::size_t kParts = 1000;
        Progress progress(context, "reading", kParts, "parts");
        RunOptions options;
        std::error_code error;
        if (!fs::equivalent(file_, recording, error)) options.recording_path = recording;
        options.load.on_progress = [&](double share) {
            progress.update(static_cast<std::size_t>(share * kParts));
        };
        if (plan.record != RecordWhat::frames) options.load.on_frame = [](const Frame&) {};
        return device.run(plan, options);
    }

    std::string file_, out_, model_;
};

}  // namespace

std::unique_ptr<Verb> make_replay_verb() { return std::make_unique<ReplayVerb>(); }

}  // namespace stria

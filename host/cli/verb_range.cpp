#include <filesystem>

#include "host/cli/progress.h"
#include "host/cli/quantity.h"
#include "host/cli/recording_range.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "host/io/range_io.h"
#include "host/project/project.h"
#include "host/scan/profiler_frame.h"

namespace stria {
namespace {

class RangeVerb final : public Verb {
  public:
    std::string name() const override { return "range"; }
    std::string summary() const override {
        return "recorded pulses to range images with a sigma on every point";
    }
    void declare(Arguments& arguments) override {
        arguments.positional("SCAN", scans_, "recording, scan folder of a project, or project");
        arguments.option("--model", model_, "calibrated scanner (scanner.toml)", true);
        arguments.option("--out", out_,
                         "range PLY to write; without it range.ply beside each recording");
        arguments.choice("--frame", frame_, {"scan", "profiler"},
                         "scan frame, or a profiler's: X along the stripe, Y travel, Z height");
        arguments.option("--footprint", footprint_,
                         "standard deviation of what a pixel sees, px, 0.2 to 3, by which points "
                         "go to the middle of the light that timed them (swept spacetime); auto: "
                         "as the pulses' texture shows it; none: points stay on their pixel's ray");
    }

    int run(const Context& context) override {
        const RangeOptions options = range_options();
        const ScannerModel model = read_scanner(model_);
        std::vector<std::string> recordings;
        for (const ScanSource& scan : resolve_scans(scans_)) {
            if (scan.recording.empty())
                throw Error(scan.name + ": holds no recording to make a range image of");
            recordings.push_back(scan.recording);
        }
        if (!out_.empty() && recordings.size() > 1)
            throw Error("--out names one file, but there are " + std::to_string(recordings.size()) +
                        " scans; leave it out");
        std::vector<JsonResult> results;
        Progress progress(context, "range images", recordings.size(), "scans");
        for (const std::string& recording : recordings) {
            const std::string out =
                !out_.empty()
                    ? out_
                    : (std::filesystem::path(recording).parent_path() / "range.ply").string();
            results.push_back(convert(context, recording, model, out, options));
            progress.update(results.size());
        }
        context.finish(JsonResult().set("scans", results));
        return 0;
    }

  private:
    JsonResult convert(const Context& context, const std::string& recording,
                       const ScannerModel& model, const std::string& out,
                       const RangeOptions& options) const {
        context.check_output(out);
        const RecordingContents contents = load_recording(recording);
        for (const std::string& note : contents.notes) context.say(recording + ": " + note);
        if (const std::string note = paths_note(contents, model); !note.empty())
            context.say(recording + ": " + note);
        RangeResult range = range_of(contents, model, recording, options);
        if (frame_ == "profiler") {
            const Channel& channel = model.channels.front();
            const double middle = 0.5 * (contents.snapshot.plan.from + contents.snapshot.plan.to);
            range.image = moved(range.image, profiler_from_scan(channel, middle));
        }
        write_range_image(out, range.image);
        context.say(out + ": " + describe(range.statistics));
        for (const std::string& note : range.notes) context.say(out + ": " + note);
        const RangeStatistics& s = range.statistics;
        JsonResult result;
        if (s.directions)
            result.set("directions", JsonResult()
                                         .set("agreeing", s.directions->agreeing)
                                         .set("unseen", s.directions->unseen)
                                         .set("displaced", s.directions->displaced)
                                         .set("beside", s.directions->beside)
                                         .set("untold", s.directions->untold)
                                         .set("points_flagged", s.contradicted));
        return result.set("recording", recording)
            .set("out", out)
            .set("points", s.points)
            .set("pulses", s.pulses)
            .set("outside_volume", s.outside_volume)
            .set("wrong_width", s.wrong_width)
            .set("median_sigma_mm", s.median_sigma_mm)
            .set("median_systematic_mm", s.median_systematic_mm)
            .set("footprint_px", s.footprint.sigma_px)
            .set("partly_lit", s.partly_lit);
    }

    RangeOptions range_options() const {
        RangeOptions options;
        if (footprint_ == "none") options.footprint_px = 0;
        if (footprint_ == "none" || footprint_ == "auto") return options;
        const double px = parse_quantity("--footprint", footprint_, Quantity::number);
        if (!(px >= 0.2 && px <= 3))
            throw Error("--footprint: expected auto, none or 0.2 to 3 px, found " + footprint_);
        options.footprint_px = px;
        return options;
    }

    std::vector<std::string> scans_;
    std::string model_, out_, frame_ = "scan", footprint_ = "auto";
};

}  // namespace

std::unique_ptr<Verb> make_range_verb() { return std::make_unique<RangeVerb>(); }

}  // namespace stria

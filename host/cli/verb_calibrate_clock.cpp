#include <cmath>
#include <filesystem>

#include "host/cli/default_plan.h"
#include "host/cli/progress.h"
#include "host/cli/recording_range.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/core/short_number.h"
#include "host/geometry/parallel.h"
#include "host/io/model_io.h"
#include "host/local/open_device.h"
#include "host/scan/clock_delay.h"

namespace stria {
namespace {

constexpr int kUsualSweeps = 3;

class CalibrateClockVerb final : public Verb {
  public:
    std::string name() const override { return "calibrate clock"; }
    std::string summary() const override {
        return "how late the axis positions are, from sweeps there and back over anything at rest";
    }
    void declare(Arguments& arguments) override {
        arguments.positional("SOURCES", sources_,
                             "one device, or recordings of sweeps in both directions");
        arguments.option("--plan", plan_,
                         "plan.toml; without it the axis' whole travel. Devices sweep it in both "
                         "directions whatever it says");
        arguments.option("--sweeps", sweeps_, "devices: how often there and back (3)");
        arguments.option("--nominal", nominal_,
                         "design model that the delay is written into; without it the device's "
                         "own");
        arguments.option("--out", out_,
                         "write the design model with the delay, for calibrate scanner --nominal");
    }

    int run(const Context& context) override {
        if (sweeps_ < 1 || sweeps_ > 100)
            throw Error("--sweeps " + std::to_string(sweeps_) + ": expected 1 to 100");
        if (!nominal_.empty() && out_.empty())
            throw Error("--nominal without --out: expected the file to write the delay into");
        ScannerModel design;
        if (!nominal_.empty()) design = design_model(read_scanner(nominal_), nominal_);
        if (!out_.empty()) context.check_output(out_);
        const std::vector<ClockDelay> delays = measure(context);
        const ClockDelay mean = mean_of(delays);
        if (!out_.empty()) {
            if (nominal_.empty()) design = design_model(stated_design_, sources_.front());
            for (Channel& channel : design.channels) channel.axis.delay_ns = mean.delay_ns;
            write_scanner(out_, design);
        }
        report(context, delays, mean);
        return 0;
    }

  private:
    /// A calibrated model's start angle has taken up what its delay lacked: both change together.
    static ScannerModel design_model(const ScannerModel& model, const std::string& name) {
        if (model.channels.empty())
            throw Error(name +
                        ": no design model is known to write the delay into; expected one "
                        "with --nominal, or no --out");
        if (model.covariance.rows() > 0)
            throw Error(name +
                        ": is a calibrated model, whose other constants have taken up what its "
                        "delay lacked; expected a design model, to calibrate anew from");
        return model;
    }

    std::vector<ClockDelay> measure(const Context& context) {
        std::vector<ClockDelay> delays;
        if (std::filesystem::is_regular_file(sources_.front())) {
            if (!plan_.empty() || sweeps_ != kUsualSweeps)
                throw Error("--plan and --sweeps belong to a device; " + sources_.front() +
                            " is a recording: expected neither");
            for (const std::string& path : sources_) {
                const RecordingContents contents = load_recording(path, LoadOptions());
                for (const std::string& note : contents.notes) context.say(path + ": " + note);
                delays.push_back(delay_of(contents, path));
            }
            return delays;
        }
        if (sources_.size() != 1)
            throw Error("expected recordings or one device; " + sources_.front() +
                        " is no recording");
        OpenOptions open;
        open.seed = context.seed;
        open.threads = thread_count();
        const auto device = open_device(sources_.front(), open);
        const Snapshot info = device->info();
        ScanPlan plan = plan_.empty() ? default_plan(info) : read_plan(plan_);
        plan.both_directions = true;
        plan.off_frames = 0;
        if (!info.model_text.empty())
            stated_design_ = parse_scanner(info.model_text, sources_.front());
        Progress progress(context, "sweeping there and back", static_cast<std::size_t>(sweeps_),
                          "sweeps");
        for (int i = 0; i < sweeps_; ++i) {
            const RecordingContents contents = device->run(plan);
            for (const std::string& note : contents.notes) context.say(note);
            delays.push_back(delay_of(contents, "sweep " + std::to_string(i + 1)));
            progress.update(static_cast<std::size_t>(i) + 1);
        }
        return delays;
    }

    ClockDelay delay_of(const RecordingContents& contents, const std::string& name) {
        if (contents.end && !contents.end->complete)
            throw Error(name + ": the sweep ended early: " + contents.end->reason);
        if (!contents.snapshot.plan.both_directions)
            throw Error(name +
                        ": swept in one direction, in which a delay looks like another "
                        "start of the axis; expected both_directions = true in its plan");
        if (contents.snapshot.plan.mode == StripeMode::spacetime &&
            contents.snapshot.device.kind != name_of(MachineKind::swept))
            throw Error(name + ": pulses of a " + contents.snapshot.device.kind +
                        " follow paths that hold a delay already; expected mode = \"spatial\" in "
                        "its plan");
        if (stated_design_.channels.empty() && !contents.snapshot.model_text.empty())
            stated_design_ = parse_scanner(contents.snapshot.model_text, name);
        std::vector<PulseMap> passes = pulses_of_passes(contents, name);
        const auto delay = clock_delay(passes);
        if (!delay)
            throw Error(name +
                        ": fewer than 100 places show the stripe in both directions and "
                        "tell where the axis is; expected something at rest in view that "
                        "the stripe moves over: a board at a slant, or any part with "
                        "slopes");
        return *delay;
    }

    void report(const Context& context, const std::vector<ClockDelay>& delays,
                const ClockDelay& mean) const {
        const auto us = [](double ns) { return short_number(1e-3 * ns, 4); };
        std::vector<JsonResult> sweeps;
        for (const ClockDelay& one : delays) {
            context.say("clock delay " + us(one.delay_ns) + " us, standard deviation " +
                        us(one.sigma_ns) + " us, from " + std::to_string(one.cells) + " places");
            sweeps.push_back(JsonResult()
                                 .set("delay_ns", one.delay_ns)
                                 .set("sigma_ns", one.sigma_ns)
                                 .set("places", static_cast<int>(one.cells)));
        }
        const bool differs = std::abs(mean.delay_ns) > 3 * mean.sigma_ns;
        context.say(differs ? "at a frame's stamp the axis is where its log has it " +
                                  us(std::abs(mean.delay_ns)) + " +- " + us(mean.sigma_ns) +
                                  " us " + (mean.delay_ns < 0 ? "earlier" : "later")
                            : "frames and axis are in step to within " + us(3 * mean.sigma_ns) +
                                  " us (3 standard deviations)");
        if (!out_.empty())
            context.say(out_ +
                        ": the design model with this delay; calibrate with calibrate "
                        "scanner --nominal " +
                        out_);
        JsonResult result;
        result.set("delay_ns", mean.delay_ns).set("sigma_ns", mean.sigma_ns).set("sweeps", sweeps);
        if (!out_.empty()) result.set("out", out_);
        context.finish(result);
    }

    std::vector<std::string> sources_;
    std::string plan_, nominal_, out_;
    int sweeps_ = kUsualSweeps;
    ScannerModel stated_design_;
};

}  // namespace

std::unique_ptr<Verb> make_calibrate_clock_verb() { return std::make_unique<CalibrateClockVerb>(); }

}  // namespace stria

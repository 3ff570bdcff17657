#include <cstdio>
#include <filesystem>

#include "calib/certify.h"
#include "calib/degeneracies.h"
#include "firmware/protocol/crc32c.h"
#include "host/cli/board_capture.h"
#include "host/cli/calibration_report.h"
#include "host/cli/camera_report.h"
#include "host/cli/progress.h"
#include "host/cli/temperature_option.h"
#include "host/cli/today.h"
#include "host/cli/verbs.h"
#include "host/cli/version.h"
#include "host/core/errors.h"
#include "host/io/certificate.h"
#include "host/io/model_io.h"

namespace stria {
namespace {

/// Views that solve, and views that check.
struct Divided {
    std::vector<CornerView> solve, check;
    std::uint32_t solve_crc = 0, check_crc = 0;
};

std::string hex(std::uint32_t crc) {
    char text[16];
    std::snprintf(text, sizeof text, "%08x", crc);
    return text;
}

Divided divided(const GatheredViews& gathered, int every) {
    Divided parts;
    std::size_t usable = 0, next = 0;
    for (const CornerView& view : gathered.views) usable += !view.corners.empty();
    for (std::size_t i = 0; i < gathered.views.size(); ++i) {
        const CornerView& view = gathered.views[i];
        const bool check = !view.corners.empty() && is_held_out(next++, usable, every);
        (check ? parts.check : parts.solve).push_back(view);
        std::uint32_t& crc = check ? parts.check_crc : parts.solve_crc;
        crc = crc32c(
            {reinterpret_cast<const std::uint8_t*>(&gathered.crcs[i]), sizeof gathered.crcs[i]},
            crc);
    }
    return parts;
}

void refuse(const std::vector<DegeneracyFinding>& findings) {
    for (const DegeneracyFinding& found : findings)
        if (found.prevents)
            throw Error(std::string("the views cannot calibrate the scanner (") +
                        name_of(found.kind) + "): " + found.text);
}

class CalibrateScannerVerb final : public Verb {
  public:
    std::string name() const override { return "calibrate scanner"; }
    std::string summary() const override {
        return "camera, laser sheet and axis from sweeps over a board";
    }
    void declare(Arguments& arguments) override {
        arguments.positional("RECORDING|DEVICE", sources_,
                             "recordings, one a placement of the board, made with off_frames; or "
                             "one device to make them with");
        arguments.option("--board", board_, "such as charuco:12x9:20:15:DICT_5X5_100", true);
        arguments.option("--out", out_, "scanner.toml to write", true);
        arguments.option("--nominal", nominal_,
                         "the machine's drawing (scanner.toml); else what the device states");
        arguments.option("--plan", plan_,
                         "with a device: plan.toml of each sweep, off_frames >= 1");
        arguments.option("--views", views_, "with a device: placements of the board (15)");
        arguments.flag("--guided", guided_,
                       "with a device: say and draw (OUT.guide.svg) where to hold the board next");
        arguments.option("--check", check_,
                         "every N-th view is held out to check the result (5; 0: none), where "
                         "there are 10 or more");
        arguments.flag("--board-warp", options_.board_warp,
                       "also solve how far the board bulges, in two numbers");
        arguments.choice(
            "--lens", lens_, {"nominal", "auto", "pinhole", "brown5", "rational8"},
            "lens model; the nominal's unless given; auto: the simplest that foretells "
            "pictures held out as well as any");
        temperature_.declare(arguments, "of the scanner now, degrees Celsius, for the certificate");
        arguments.option("--valid-days", valid_days_, "until the certificate expires (90)");
    }

    int run(const Context& context) override {
        const Board board = parse_board(board_);
        check_options();
        context.check_output(out_);
        GatheredViews gathered;
        if (!nominal_.empty()) {
            gathered.nominal = read_scanner(nominal_);
            gathered.has_nominal = true;
        }
        gather(context, board, gathered);
        refuse(find_degeneracies(gathered.views, board, gathered.nominal));
        const Divided parts = divided(gathered, check_);
        if (lens_ == "auto") context.say("choosing the lens model by pictures held out");
        const auto choice = set_lens(parts.solve, board, gathered.nominal);
        if (choice) say_choice(context, *choice);
        context.say("solving " + std::to_string(parts.solve.size()) + " views");
        CalibrationOutcome outcome = solve(parts, board, gathered);
        write(outcome);
        outcome.lens = choice;
        report_calibration(context, outcome);
        return outcome.certificate.status == CertificateStatus::failed ? 1 : 0;
    }

  private:
    void check_options() const {
        if (check_ < 0 || check_ == 1)
            throw Error("--check " + std::to_string(check_) +
                        ": expected 2 or more, or 0 to hold no view out");
        if (valid_days_ < 1 || valid_days_ > 3650)
            throw Error("--valid-days " + std::to_string(valid_days_) + ": expected 1 to 3650");
        if (views_ < 3) throw Error("--views " + std::to_string(views_) + ": expected 3 or more");
        temperature_.value();
    }

    void gather(const Context& context, const Board& board, GatheredViews& gathered) const {
        const bool files = std::filesystem::is_regular_file(sources_.front());
        if (files && (!plan_.empty() || guided_ || views_ != kUsualViews))
            throw Error("--plan, --views and --guided belong to a device; " + sources_.front() +
                        " is a recording");
        if (files) return from_recordings(context, board, gathered);
        if (sources_.size() != 1)
            throw Error("expected recordings or one device; " + sources_.front() +
                        " is no recording");
        if (plan_.empty()) throw Error("a device needs --plan FILE, with off_frames = 1 or more");
        BoardCaptureOptions capture{.device = sources_.front(),
                                    .plan = read_plan(plan_),
                                    .views = views_,
                                    .check_every = check_,
                                    .guided = guided_,
                                    .picture_path = out_ + ".guide.svg"};
        if (capture.plan.off_frames < 1)
            throw Error(plan_ + ": off_frames = " + std::to_string(capture.plan.off_frames) +
                        "; expected 1 or more, or the board is not seen (rail, turntable: 5)");
        capture_views(context, board, capture, gathered);
    }

    /// Gives the nominal the lens model that --lens asks for, or the one the views speak for.
    std::optional<LensChoice> set_lens(const std::vector<CornerView>& views, const Board& board,
                                       ScannerModel& nominal) const {
        if (lens_ == "nominal") return {};
        const CameraModel& drawn = nominal.channels.front().camera;
        std::optional<LensChoice> choice;
        if (lens_ == "auto")
            choice = choose_lens(pictures_of(views), board, drawn.width, drawn.height);
        for (Channel& channel : nominal.channels)
            channel.camera =
                with_lens(channel.camera, choice ? choice->lens : *lens_kind_from(lens_));
        return choice;
    }

    void from_recordings(const Context& context, const Board& board,
                         GatheredViews& gathered) const {
        Progress progress(context, "finding the board", sources_.size(), "recordings");
        for (std::size_t i = 0; i < sources_.size(); ++i) {
            LoadOptions load;
            const RecordingContents contents = load_recording(sources_[i], load);
            for (const std::string& note : contents.notes) context.say(sources_[i] + ": " + note);
            add_view(gathered, contents, board, sources_[i]);
            progress.update(i + 1);
        }
    }

    CalibrationOutcome solve(const Divided& parts, const Board& board,
                             const GatheredViews& gathered) const {
        CalibrationOutcome outcome;
        outcome.found = calibrate_scanner(parts.solve, board, gathered.nominal, options_);
        refuse(find_contradictions(outcome.found.model, gathered.nominal,
                                   options_.nominal_length_sigma_mm));
        Provenance& provenance = outcome.found.model.provenance;
        provenance.made_by = std::string("stria ") + kVersion;
        provenance.data_hash = hex(parts.solve_crc);
        outcome.halves = cross_validate(parts.solve, board, outcome.found);
        outcome.check = check_held_out(parts.check, board, outcome.found);
        Certificate& certificate = outcome.certificate;
        certificate = certify(outcome.found, outcome.check, outcome.halves);
        if (!gathered.simulated) {
            provenance.date = certificate.date = today();
            certificate.expires = days_after(certificate.date, valid_days_);
        }
        if (!parts.check.empty()) certificate.check_hash = hex(parts.check_crc);
        certificate.temperature_c = temperature_.value();
        compare_with_former(parts.solve, outcome);
        return outcome;
    }

    void compare_with_former(const std::vector<CornerView>& views,
                             CalibrationOutcome& outcome) const {
        if (!std::filesystem::exists(out_)) return;
        outcome.replaced = out_;
        try {
            outcome.movement = movement_of(read_scanner(out_), outcome.found.model,
                                           pulse_samples(views, outcome.found.model));
        } catch (const Error& error) {
            outcome.movement.why_not = error.what();
        }
    }

    /// A failed calibration never replaces what stands there: it goes beside it.
    void write(CalibrationOutcome& outcome) const {
        const bool failed = outcome.certificate.status == CertificateStatus::failed;
        outcome.written = failed && !outcome.replaced.empty() ? out_ + ".failed" : out_;
        write_scanner(outcome.written, outcome.found.model, outcome.certificate);
    }

    std::vector<std::string> sources_;
    std::string board_, out_, nominal_, plan_, lens_ = "nominal";
    static constexpr int kUsualViews = 15;
    int views_ = kUsualViews, check_ = 5, valid_days_ = 90;
    TemperatureOption temperature_;
    bool guided_ = false;
    ScannerCalibrationOptions options_;
};

}  // namespace

std::unique_ptr<Verb> make_calibrate_scanner_verb() {
    return std::make_unique<CalibrateScannerVerb>();
}

}  // namespace stria

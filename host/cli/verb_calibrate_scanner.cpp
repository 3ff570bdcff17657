#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "calib/scanner_calibration.h"
#include "firmware/protocol/crc32c.h"
#include "host/cli/calibration_views.h"
#include "host/cli/progress.h"
#include "host/cli/verbs.h"
#include "host/cli/version.h"
#include "host/core/errors.h"
#include "host/geometry/parallel.h"
#include "host/io/model_io.h"
#include "host/local/open_device.h"

namespace stria {
namespace {

/// Views gathered so far, the machine's drawing, and a check sum of what was measured.
struct Gathered {
    std::vector<CornerView> views;
    ScannerModel nominal;
    bool has_nominal = false;
    std::uint32_t crc = 0;
};

std::uint32_t check_sum(const CalibrationView& view, std::uint32_t crc) {
    const auto add = [&](const void* data, std::size_t size) {
        crc = crc32c({static_cast<const std::uint8_t*>(data), size}, crc);
    };
    for (const BoardImage& image : view.images) {
        add(image.image.values.data(), image.image.values.size());
        add(&image.s, sizeof image.s);
    }
    const auto add_pulses = [&](const PulseMap& pass) {
        for (const Pulse& pulse : pass.pulses) {
            const double numbers[] = {pulse.u, pulse.v, pulse.s};
            add(numbers, sizeof numbers);
        }
    };
    add_pulses(view.pulses);
    for (const PulseMap& pass : view.further_passes) add_pulses(pass);
    return crc;
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
        arguments.flag("--guided", guided_, "with a device: say how to place the board each time");
    }

    int run(const Context& context) override {
        const Board board = parse_board(board_);
        context.check_output(out_);
        Gathered gathered;
        if (!nominal_.empty()) {
            gathered.nominal = read_scanner(nominal_);
            gathered.has_nominal = true;
        }
        const bool files = std::filesystem::is_regular_file(sources_.front());
        if (files && (!plan_.empty() || guided_))
            throw Error("--plan and --guided belong to a device; " + sources_.front() +
                        " is a recording");
        if (files)
            from_recordings(context, board, gathered);
        else
            from_device(context, board, gathered);
        context.say("solving " + std::to_string(gathered.views.size()) + " views");
        ScannerCalibration found = calibrate_scanner(gathered.views, board, gathered.nominal);
        char hash[16];
        std::snprintf(hash, sizeof hash, "%08x", gathered.crc);
        found.model.provenance.made_by = std::string("stria ") + kVersion;
        found.model.provenance.data_hash = hash;
        write_scanner(out_, found.model);
        report(context, found);
        return 0;
    }

  private:
    static void take(Gathered& gathered, const RecordingContents& contents, const Board& board,
                     const std::string& name) {
        if (!gathered.has_nominal) {
            gathered.nominal = nominal_model_of(contents, name);
            gathered.has_nominal = true;
        }
        const CalibrationView view = calibration_view_of(contents, name);
        gathered.crc = check_sum(view, gathered.crc);
        gathered.views.push_back(find_corners(view, board));
    }

    void from_recordings(const Context& context, const Board& board, Gathered& gathered) const {
        Progress progress(context, "finding the board", sources_.size(), "recordings");
        for (std::size_t i = 0; i < sources_.size(); ++i) {
            LoadOptions load;
            const RecordingContents contents = load_recording(sources_[i], load);
            for (const std::string& note : contents.notes) context.say(sources_[i] + ": " + note);
            take(gathered, contents, board, sources_[i]);
            progress.update(i + 1);
        }
    }

    void from_device(const Context& context, const Board& board, Gathered& gathered) const {
        if (sources_.size() != 1)
            throw Error("expected recordings or one device; " + sources_.front() +
                        " is no recording");
        if (plan_.empty()) throw Error("a device needs --plan FILE, with off_frames = 1 or more");
        const ScanPlan plan = read_plan(plan_);
        if (plan.off_frames < 1)
            throw Error(plan_ + ": off_frames = " + std::to_string(plan.off_frames) +
                        "; expected 1 or more, or the board is not seen (rail, turntable: 5)");
        OpenOptions open;
        open.seed = context.seed;
        open.threads = thread_count();
        const auto device = open_device(sources_.front(), open);
        bool has_views = false;
        for (const Feature& feature : device->features())
            has_views = has_views || feature.name == "SceneView";
        Progress progress(context, "sweeping over the board", static_cast<std::size_t>(views_),
                          "views");
        for (int view = 0; view < views_; ++view) {
            if (has_views)
                device->set_feature("SceneView", FeatureValue(std::int64_t{view}));
            else
                ask_for_board(view);
            const std::string name = "view " + std::to_string(view + 1);
            RunOptions options;
            if (plan.record != RecordWhat::frames) options.load.on_frame = [](const Frame&) {};
            take(gathered, device->run(plan, options), board, name);
            for (const std::string& refusal : gathered.views.back().refusals) context.say(refusal);
            progress.update(static_cast<std::size_t>(view) + 1);
        }
    }

    /// Waits until the person has placed the board.
    void ask_for_board(int view) const {
        static const char* const kPlaces[] = {"in the middle, facing the camera",
                                              "turned 30 deg to the left",
                                              "turned 30 deg to the right",
                                              "tilted 30 deg back",
                                              "tilted 30 deg forward",
                                              "near, in the upper left",
                                              "near, in the lower right, turned",
                                              "far, in the upper right",
                                              "far, in the lower left, tilted"};
        std::cerr << "view " << view + 1 << " of " << views_ << ": place the board";
        if (guided_) std::cerr << ' ' << kPlaces[static_cast<std::size_t>(view) % 9];
        std::cerr << ", let it rest and press Enter\n";
        std::string line;
        if (!std::getline(std::cin, line))
            throw Error("input ended while waiting for the board of view " +
                        std::to_string(view + 1));
    }

    void report(const Context& context, const ScannerCalibration& found) const {
        const Eigen::Vector3d size = found.model.volume.max - found.model.volume.min;
        std::vector<JsonResult> views, rejected;
        for (const ScannerViewResult& view : found.views) {
            if (!view.rejected.empty()) {
                rejected.push_back(
                    JsonResult().set("file", view.name).set("reason", view.rejected));
                context.say("not used: " + view.name + ": " + view.rejected);
            }
            for (const std::string& note : view.notes) context.say(view.name + ": " + note);
            views.push_back(JsonResult()
                                .set("name", view.name)
                                .set("rms_px", view.rms_px)
                                .set("stripe_rms_sigma", view.stripe_rms)
                                .set("corners_used", view.corners_used)
                                .set("corners_rejected", view.corners_rejected)
                                .set("stripe_points_used", view.stripe_points_used)
                                .set("stripe_points_rejected", view.stripe_points_rejected)
                                .set("notes", view.notes));
        }
        std::ostringstream line;
        line << out_ << ": corners " << found.rms_px << " px rms over " << found.views_used
             << " views, predicted point sigma " << found.predicted.median_mm
             << " mm (95 %: " << found.predicted.p95_mm << ") over " << size.x() << " x "
             << size.y() << " x " << size.z() << " mm";
        context.say(line.str());
        for (const std::string& warning : found.warnings) context.say("warning: " + warning);
        context.finish(
            JsonResult()
                .set("rms_px", found.rms_px)
                .set("predicted_sigma_mm", JsonResult()
                                               .set("median", found.predicted.median_mm)
                                               .set("p95", found.predicted.p95_mm))
                .set("volume_mm3", size.prod())
                .set("warnings", found.warnings)
                .set("views_used", found.views_used)
                .set("views_rejected", rejected)
                .set("views", views)
                .set("certificate", JsonResult()
                                        .set("converged", found.converged)
                                        .set("chi_square_per_dof", found.chi_square_per_dof)
                                        .set("corner_sigma_px", found.corner_sigma_px)
                                        .set("stripe_sigma_factor", found.stripe_sigma_factor)
                                        .set("weakest", found.predicted.weakest)
                                        .set("data_hash", found.model.provenance.data_hash)));
    }

    std::vector<std::string> sources_;
    std::string board_, out_, nominal_, plan_;
    int views_ = 15;
    bool guided_ = false;
};

}  // namespace

std::unique_ptr<Verb> make_calibrate_scanner_verb() {
    return std::make_unique<CalibrateScannerVerb>();
}

}  // namespace stria

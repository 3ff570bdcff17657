#include <cmath>
#include <filesystem>

#include "calib/sheet_file.h"
#include "host/cli/progress.h"
#include "host/cli/sheet_views.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/core/frame_image.h"
#include "host/core/short_number.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"
#include "host/render/stripe_picture.h"

namespace stria {
namespace {

class CalibrateSheetVerb final : public Verb {
  public:
    explicit CalibrateSheetVerb(std::string word) : word_(std::move(word)) {}
    std::string name() const override { return "calibrate " + word_; }
    std::string summary() const override {
        return word_ == "sheet" ? "the laser's sheet from views of a board with the stripe on it"
                                : "another name of calibrate sheet";
    }
    void declare(Arguments& arguments) override {
        arguments.positional("IMAGES", photographs_.with_stripe,
                             "pictures with the stripe over the board, one a placement");
        arguments.option("--board", board_, "such as chessboard:9x6:25", true);
        arguments.option("--camera", camera_, "camera.toml of calibrate camera", true);
        arguments.option("--laser-off", photographs_.laser_off,
                         "the same placements without laser, in the order of IMAGES: the board is "
                         "found in these, and their light is subtracted");
        arguments.option("--out", out_, "sheet.toml to write: camera, sheet and covariance", true);
        arguments.choice("--channel", photographs_.channel,
                         {"auto", "red", "green", "blue", "grey"},
                         "which channel of colour images shows the stripe; auto without "
                         "--laser-off: the laser's colour alone");
        arguments.choice("--axis", photographs_.axis, {"auto", "rows", "columns"},
                         "look for one peak a row or one a column; auto: what finds more");
        arguments.option("--overlay", overlay_,
                         "folder for PNGs with the stripe points used drawn in");
    }

    int run(const Context& context) override {
        const Board board = parse_board(board_);
        const CameraModel camera = read_camera(camera_);
        context.check_output(out_);
        const std::size_t count = photographs_.with_stripe.size();
        Progress progress(context, "board and stripe", count, "images");
        const SheetViews read = read_sheet_views(photographs_, board, camera,
                                                 [&](std::size_t done) { progress.update(done); });
        const SheetCalibration found = calibrate_sheet(read.views, board, camera);
        if (!overlay_.empty()) draw_overlays(found);
        write_sheet(out_, {camera, found.normal, found.offset_mm, found.covariance});
        report(context, found, read.refused);
        return 0;
    }

  private:
    void draw_overlays(const SheetCalibration& found) const {
        std::filesystem::create_directories(overlay_);
        for (const SheetViewResult& view : found.views) {
            if (!view.rejected.empty()) continue;
            const LoadedImage image = read_image(view.name);
            const Frame frame =
                frame_from_image(select_channel(image, strongest_channel(image)), image.bits);
            std::vector<Pulse> peaks(view.pixels.size());
            for (std::size_t i = 0; i < peaks.size(); ++i) {
                peaks[i].u = static_cast<float>(view.pixels[i].x());
                peaks[i].v = static_cast<float>(view.pixels[i].y());
            }
            const std::string stem = std::filesystem::path(view.name).stem().string();
            write_png(overlay_ + "/" + stem + ".png", picture_of_peaks(frame, peaks));
        }
    }

    void report(const Context& context, const SheetCalibration& found,
                std::vector<RefusedPhotograph> refused) const {
        for (const SheetViewResult& view : found.views)
            if (!view.rejected.empty()) refused.push_back({view.name, view.rejected});
        say(context, found, refused);
        std::vector<JsonResult> rejected, views;
        for (const RefusedPhotograph& one : refused)
            rejected.push_back(JsonResult().set("file", one.file).set("reason", one.reason));
        for (const SheetViewResult& view : found.views)
            if (view.rejected.empty())
                views.push_back(JsonResult()
                                    .set("file", view.name)
                                    .set("points", view.points)
                                    .set("rms_mm", view.rms_mm)
                                    .set("left_out_rms_mm", view.left_out_rms_mm));
        const Eigen::Vector4d sigma = found.covariance.diagonal().cwiseMax(0).cwiseSqrt();
        JsonResult result;
        result.set("rms_mm", found.rms_mm)
            .set("points_used", found.points_used)
            .set("views_used", found.views_used)
            .set("views_rejected", rejected)
            .set("sheet", JsonResult()
                              .set("normal", Eigen::VectorXd(found.normal))
                              .set("offset_mm", found.offset_mm))
            .set("sigma", JsonResult()
                              .set("normal", Eigen::VectorXd(sigma.head<3>()))
                              .set("turn_rad", found.turn_sigma_rad)
                              .set("offset_mm", sigma[3]))
            .set("chi_square", found.chi_square)
            .set("corner_sigma_px", found.corner_sigma_px)
            .set("views", views);
        if (found.views_used >= 3) result.set("left_out_rms_mm", found.left_out_rms_mm);
        context.finish(result);
    }

    void say(const Context& context, const SheetCalibration& found,
             const std::vector<RefusedPhotograph>& refused) const {
        const auto number = [](double value) { return short_number(value, 6); };
        context.say(out_ + ": " + number(found.rms_mm) + " mm rms over " +
                    std::to_string(found.points_used) + " stripe points of " +
                    std::to_string(found.views_used) + " views; normal " +
                    number(found.normal.x()) + " " + number(found.normal.y()) + " " +
                    number(found.normal.z()) + " +- " + number(found.turn_sigma_rad) +
                    " rad, offset " + number(found.offset_mm) + " +- " +
                    number(std::sqrt(found.covariance(3, 3))) + " mm");
        if (found.views_used >= 3)
            context.say("each view against the sheet of the others: " +
                        number(found.left_out_rms_mm) + " mm rms");
        else
            context.say("two views leave nothing to check the sheet with: take a third");
        for (const RefusedPhotograph& one : refused)
            context.say("not used: " + one.file + ": " + one.reason);
    }

    std::string word_, board_, camera_, out_, overlay_;
    SheetPhotographs photographs_;
};

}  // namespace

std::unique_ptr<Verb> make_calibrate_sheet_verb() {
    return std::make_unique<CalibrateSheetVerb>("sheet");
}
std::unique_ptr<Verb> make_calibrate_plane_verb() {
    return std::make_unique<CalibrateSheetVerb>("plane");
}

}  // namespace stria

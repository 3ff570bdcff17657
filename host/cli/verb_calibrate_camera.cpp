#include <charconv>
#include <optional>
#include <sstream>

#include "calib/camera_calibration.h"
#include "calib/corner_table.h"
#include "calib/detect_board.h"
#include "host/cli/camera_report.h"
#include "host/cli/progress.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"

namespace stria {
namespace {

/// Views and what could not become one.
struct Views {
    std::vector<CameraView> views;
    std::vector<JsonResult> refused;
    std::vector<std::string> refused_lines;  ///< the same for people
    int width = 0, height = 0;
};

JsonResult rejection(const std::string& file, const std::string& reason) {
    return JsonResult().set("file", file).set("reason", reason);
}

class CalibrateCameraVerb final : public Verb {
  public:
    std::string name() const override { return "calibrate camera"; }
    std::string summary() const override { return "lens and focal length from views of a board"; }
    void declare(Arguments& arguments) override {
        arguments.positional("IMAGES", images_, "pictures of the board, PNG, JPEG or TIFF", false);
        arguments.option("--board", board_, "such as chessboard:9x6:25", true);
        arguments.option("--out", out_, "camera.toml to write", true);
        arguments.choice("--model", model_, {"auto", "pinhole", "brown5", "rational8"},
                         "lens model; brown5 unless given, rational8 for very wide lenses; auto: "
                         "the simplest that foretells views held out as well as any");
        arguments.option("--corners", corners_,
                         "instead of images: table \"view row col x y weight\"");
        arguments.option("--image-size", size_, "with --corners: WIDTHxHEIGHT, px");
        arguments.flag("--board-warp", warp_, "also solve how far the board bulges");
    }

    int run(const Context& context) override {
        const Board board = parse_board(board_);
        context.check_output(out_);
        if (images_.empty() == corners_.empty())
            throw Error("expected either pictures of the board or --corners FILE");
        if (corners_.empty() != size_.empty())
            throw Error("--corners and --image-size go together");
        Views views = corners_.empty() ? from_images(context, board) : from_table(board);
        CameraCalibrationOptions options;
        std::optional<LensChoice> choice;
        if (model_ == "auto") {
            context.say("choosing the lens model by views held out");
            choice = choose_lens(views.views, board, views.width, views.height);
        }
        options.lens = choice ? choice->lens : *lens_kind_from(model_);
        options.board_warp = warp_;
        const CameraCalibration found =
            calibrate_camera(views.views, board, views.width, views.height, options);
        write_camera(out_, found.camera);
        if (choice) say_choice(context, *choice);
        report(context, found, choice, std::move(views.refused), views.refused_lines);
        return 0;
    }

  private:
    Views from_images(const Context& context, const Board& board) const {
        Views result;
        Progress progress(context, "finding the board", images_.size(), "images");
        for (std::size_t i = 0; i < images_.size(); ++i) {
            const GreyImage image = read_grey_image(images_[i]);
            if (result.width == 0) {
                result.width = image.width;
                result.height = image.height;
            }
            if (image.width != result.width || image.height != result.height)
                throw Error(images_[i] + ": " + std::to_string(image.width) + " x " +
                            std::to_string(image.height) + " px, but " + images_[0] + " has " +
                            std::to_string(result.width) + " x " + std::to_string(result.height) +
                            "; one camera has one size");
            const Detection found = detect_board(image, board);
            if (found.found()) {
                result.views.push_back({images_[i], found.ids, found.pixels, {}});
            } else {
                result.refused.push_back(rejection(images_[i], found.refusal));
                result.refused_lines.push_back("not used: " + images_[i] + ": " + found.refusal);
            }
            progress.update(i + 1);
        }
        if (result.views.empty()) {
            std::string why = "the board " + to_string(board) + " was found in none of " +
                              std::to_string(images_.size()) + " pictures";
            for (const std::string& line : result.refused_lines) why += "\n  " + line;
            throw Error(why);
        }
        return result;
    }

    Views from_table(const Board& board) const {
        Views result;
        const auto cross = size_.find('x');
        const auto number = [&](std::string text) {
            int value = 0;
            const auto [end, error] =
                std::from_chars(text.data(), text.data() + text.size(), value);
            if (error != std::errc() || end != text.data() + text.size() || value < 1 ||
                value > 16384)
                throw Error("--image-size " + size_ + ": expected WIDTHxHEIGHT, 1 to 16384 each");
            return value;
        };
        result.width = number(size_.substr(0, cross));
        result.height = number(cross == std::string::npos ? "" : size_.substr(cross + 1));
        result.views = read_corner_table(corners_, board);
        return result;
    }

    void report(const Context& context, const CameraCalibration& found,
                const std::optional<LensChoice>& choice, std::vector<JsonResult> rejected,
                const std::vector<std::string>& refused) const {
        std::vector<JsonResult> corners_rejected;
        std::vector<std::string> lines = refused;
        for (const CameraViewResult& view : found.views) {
            if (!view.rejected.empty()) {
                rejected.push_back(rejection(view.name, view.rejected));
                lines.push_back("not used: " + view.name + ": " + view.rejected);
            } else if (!view.ids_rejected.empty()) {
                std::vector<double> ids(view.ids_rejected.begin(), view.ids_rejected.end());
                lines.push_back(view.name + ": " + std::to_string(ids.size()) +
                                " corners left out: weight 0, or far off all others");
                corners_rejected.push_back(
                    rejection(view.name, "weight 0, or far off all others").set("corners", ids));
            }
        }
        const CameraModel& camera = found.camera;
        const int lens = distortion_count(camera.kind);
        const std::vector<double> distortion(camera.distortion.begin(),
                                             camera.distortion.begin() + lens);
        const auto sigma = [&](int i) { return std::sqrt(found.covariance(i, i)); };
        std::ostringstream line;
        line << out_ << ": rms " << found.rms_px << " px over " << found.points_used
             << " points of " << found.views_used << " views, fx " << camera.fx << " +- "
             << sigma(0) << ", fy " << camera.fy << " +- " << sigma(1) << ", centre " << camera.cx
             << " " << camera.cy;
        context.say(line.str());
        for (const std::string& left_out : lines) context.say(left_out);
        say_noise(context, found.noise,
                  "a flat board or --board-warp, --model rational8 for a wide lens, pictures that "
                  "the camera has not sharpened");
        JsonResult result;
        result.set("rms_px", found.rms_px)
            .set("views_used", found.views_used)
            .set("views_rejected", rejected)
            .set("corners_rejected", corners_rejected)
            .set("points_used", found.points_used)
            .set("converged", found.converged)
            .set("camera", JsonResult()
                               .set("width", camera.width)
                               .set("height", camera.height)
                               .set("model", name_of(camera.kind))
                               .set("fx", camera.fx)
                               .set("fy", camera.fy)
                               .set("cx", camera.cx)
                               .set("cy", camera.cy)
                               .set("distortion", distortion))
            .set("sigma", JsonResult()
                              .set("fx", sigma(0))
                              .set("fy", sigma(1))
                              .set("cx", sigma(2))
                              .set("cy", sigma(3)))
            .set("corner_noise", json_of(found.noise));
        if (choice) result.set("lens_trials", json_of(*choice));
        if (warp_)
            result.set("board_warp_mm",
                       std::vector<double>{found.board_warp_mm.x(), found.board_warp_mm.y()});
        context.finish(result);
    }

    std::vector<std::string> images_;
    std::string board_, out_, model_ = "brown5", corners_, size_;
    bool warp_ = false;
};

}  // namespace

std::unique_ptr<Verb> make_calibrate_camera_verb() {
    return std::make_unique<CalibrateCameraVerb>();
}

}  // namespace stria

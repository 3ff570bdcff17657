#include "calib/board_print.h"
#include "host/cli/verbs.h"
#include "host/core/board.h"
#include "host/core/errors.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

bool ends_with(const std::string& text, const std::string& end) {
    return text.size() >= end.size() &&
           text.compare(text.size() - end.size(), end.size(), end) == 0;
}

class CalibrateBoardVerb final : public Verb {
  public:
    std::string name() const override { return "calibrate board"; }
    std::string summary() const override { return "a target to print, at true scale"; }
    void declare(Arguments& arguments) override {
        arguments.positional("BOARD", board_,
                             "such as charuco:12x9:20:15:DICT_5X5_100 or chessboard:9x6:25");
        arguments.option("--out", out_, "PDF or SVG file to write", true);
    }

    int run(const Context& context) override {
        const Board board = parse_board(board_);
        const bool pdf = ends_with(out_, ".pdf") || ends_with(out_, ".PDF");
        if (!pdf && !ends_with(out_, ".svg") && !ends_with(out_, ".SVG"))
            throw Error("--out " + out_ + ": expected a name ending in .pdf or .svg");
        context.check_output(out_);
        write_whole_file(out_, pdf ? board_pdf(board) : board_svg(board));
        const Eigen::Vector2d size = pattern_size_mm(board);
        context.say(out_ + ": " + to_string(board) + "; print at 100 %, then measure the ruler");
        context.finish(JsonResult()
                           .set("board", to_string(board))
                           .set("out", out_)
                           .set("width_mm", size.x())
                           .set("height_mm", size.y())
                           .set("corners", board_points(board).size()));
        return 0;
    }

  private:
    std::string board_, out_;
};

}  // namespace

std::unique_ptr<Verb> make_calibrate_board_verb() { return std::make_unique<CalibrateBoardVerb>(); }

}  // namespace stria

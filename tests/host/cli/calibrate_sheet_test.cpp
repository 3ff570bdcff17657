#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "calib/sheet_file.h"
#include "firmware/core/angle.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "tests/calib/photographed_board.h"
#include "tests/calib/sheet_error.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"

/// Pictures of a board with a red stripe, by ray casting from a known sheet.
namespace stria {
namespace {

using test_support::Ended;
using test_support::has;
using test_support::number_of;
using test_support::run_stria;

const FlatSheet kSheet = {Eigen::Vector3d(0.94, 0.02, 0.34).normalized(), 170};
const std::string kBoardText = "chessboard:8x5:18";

CameraModel camera() {
    CameraModel camera;
    camera.width = 480;
    camera.height = 360;
    camera.fx = camera.fy = 620;
    camera.cx = 239.5;
    camera.cy = 179.5;
    return camera;
}

class CalibrateSheet : public testing::Test {
  protected:
    void SetUp() override {
        write_camera(folder_ / "camera.toml", camera());
        const Board board = parse_board(kBoardText);
        const Eigen::Vector3d turns[] = {
            {0.4, 0.1, 0}, {-0.3, 0.3, 0}, {0.1, -0.4, -0.2}, {-0.2, -0.2, 0.3}};
        for (int i = 0; i < 4; ++i) {
            const double z = 380 + 45 * i;
            const double x = (kSheet.offset_mm - kSheet.normal.z() * z) / kSheet.normal.x();
            poses_.push_back(board_at(board, {x, 3.0 * i, z}, turns[i]));
            PhotographOptions options = {.seed = static_cast<unsigned>(10 + i)};
            write_png(off(i), photograph(camera(), poses_.back(), board, options));
            options.sheet = kSheet;
            options.seed += 100;
            write_png(on(i), photograph(camera(), poses_.back(), board, options));
        }
    }
    std::string on(int i) const { return folder_ / ("on" + std::to_string(i) + ".png"); }
    std::string off(int i) const { return folder_ / ("off" + std::to_string(i) + ".png"); }
    std::string out() const { return folder_ / "sheet.toml"; }

    std::vector<std::string> command(const std::vector<std::string>& images,
                                     const std::vector<std::string>& more = {}) const {
        std::vector<std::string> all = {"calibrate", "sheet"};
        all.insert(all.end(), images.begin(), images.end());
        for (const std::string& word : {std::string("--board"), kBoardText, std::string("--camera"),
                                        folder_ / "camera.toml", std::string("--out"), out()})
            all.push_back(word);
        all.insert(all.end(), more.begin(), more.end());
        return all;
    }

    TemporaryFolder folder_;
    std::vector<Rigid3> poses_;
};

TEST_F(CalibrateSheet, FindsTheSheetInPairsAndInSinglePictures) {
    for (const bool pairs : {false, true}) {
        std::vector<std::string> more = {"--json", "--force"};
        if (pairs) more.insert(more.end(), {"--laser-off", off(0), off(1), off(2), off(3)});
        const Ended ended = run_stria(command({on(0), on(1), on(2), on(3)}, more));
        ASSERT_EQ(ended.code, 0) << ended.err;
        const MeasuredSheet sheet = read_sheet(out());
        const double turn = angle_rad(sheet.normal, kSheet.normal);
        std::cout << (pairs ? "pairs" : "single") << ": " << turn / kDegree << " deg, "
                  << sheet.offset_mm - kSheet.offset_mm << " mm, rms "
                  << number_of(ended.out, "rms_mm") << " mm, left out "
                  << number_of(ended.out, "left_out_rms_mm") << " mm, sigma "
                  << number_of(ended.out, "turn_rad") / kDegree << " deg\n";
        // 0.1 % quantile of chi-square with 3 degrees of freedom
        EXPECT_LT(sheet_chi_square(sheet.normal, sheet.offset_mm, sheet.covariance, kSheet), 16.27);
        EXPECT_LT(turn, 0.1 * kDegree);
        EXPECT_LT(number_of(ended.out, "left_out_rms_mm"), 0.3);  // mm: 0.1 px is 0.16 here
        EXPECT_EQ(number_of(ended.out, "views_used"), 4);
        // Half of the 390 rows that the stripe crosses the board in are white squares', a quarter
        // of these are near an edge; black squares return 8 DN, below 6 standard deviations of
        // noise.
        EXPECT_GT(number_of(ended.out, "points_used"), 140);
        for (const char* key :
             {"\"views_rejected\": []", "\"normal\"", "\"offset_mm\"", "\"sigma\""})
            EXPECT_TRUE(has(ended.out, key)) << key << "\n" << ended.out;
    }
}

TEST_F(CalibrateSheet, SynonymAndOptionsDoWhatTheySay) {
    auto words = command({on(0), on(1), on(2)}, {"--json", "--axis", "rows"});
    const Ended sheet = run_stria(words);
    ASSERT_EQ(sheet.code, 0) << sheet.err;
    words[1] = "plane";
    words.push_back("--force");
    const Ended plane = run_stria(words);
    EXPECT_EQ(plane.out, sheet.out);
    // The stripe is upright: a column meets it nowhere or along it; green holds no laser.
    const Ended columns =
        run_stria(command({on(0), on(1), on(2)}, {"--force", "--axis", "columns"}));
    EXPECT_EQ(columns.code, 1);
    EXPECT_TRUE(has(columns.err, "stripe not crossing")) << columns.err;
    const Ended green =
        run_stria(command({on(0), on(1), on(2)}, {"--force", "--channel", "green"}));
    EXPECT_EQ(green.code, 1);
    EXPECT_TRUE(has(green.err, "stripe not crossing")) << green.err;
}

TEST_F(CalibrateSheet, RefusesByNameAndLeavesWhatWasThere) {
    write_whole_file(out(), "old");
    const auto refused = [&](std::vector<std::string> words, const std::string& why) {
        const Ended ended = run_stria(words);
        EXPECT_EQ(ended.code, 1) << why;
        EXPECT_TRUE(has(ended.err, why)) << why << "\n" << ended.err;
        EXPECT_EQ(read_whole_file(out()), "old") << why;
    };
    const std::vector<std::string> all = {on(0), on(1), on(2)};
    refused(command(all), "--force");
    refused(command({on(0)}, {"--force"}), "at least 2 placements");
    refused(command({off(0), off(1), off(2)}, {"--force"}), "expected --laser-off pictures");
    refused(command({off(0), off(1)}, {"--force", "--laser-off", off(0), off(1)}),
            "stripe not crossing");
    refused(command(all, {"--force", "--laser-off", off(0)}), "expected one for each");
    refused(command({on(0), folder_ / "none.png"}, {"--force"}), "none.png");

    auto words = command(all, {"--force"});
    words[6] = "chessboard:7x4:18";
    refused(words, "wrong board");

    ColourImage small(200, 100, 3, 50);
    write_png(folder_ / "small.png", small);
    refused(command({on(0), folder_ / "small.png"}, {"--force"}), "200 x 100");
    refused(command(all, {"--force", "--laser-off", off(0), folder_ / "small.png", off(2)}),
            "200 x 100");

    std::string text = read_whole_file(folder_ / "camera.toml");
    text.replace(text.find("fx = "), text.find('\n', text.find("fx = ")) - text.find("fx = "),
                 "fx = nan");
    write_whole_file(folder_ / "camera.toml", text);
    refused(command(all, {"--force"}), "fx");
}

TEST_F(CalibrateSheet, DrawsThePointsItUsed) {
    const std::string drawn = folder_ / "drawn";
    const Ended ended = run_stria(command({on(0), on(1)}, {"--overlay", drawn}));
    ASSERT_EQ(ended.code, 0) << ended.err;
    for (const char* name : {"/on0.png", "/on1.png"}) {
        const LoadedImage picture = read_image(drawn + name);
        EXPECT_EQ(picture.pixels.width, 3 * camera().width) << name;
        int green = 0;
        for (int y = 0; y < picture.pixels.height; ++y)
            for (int x = 0; x < picture.pixels.width; ++x)
                green += picture.pixels.at(x, y, 1) > picture.pixels.at(x, y, 0) + 60;
        EXPECT_GT(green, 100) << name;  // px: a cross a point, 20 points at least
    }
}

TEST_F(CalibrateSheet, SaysThatTheBoardMovedBetweenThePicturesOfAPair) {
    const Board board = parse_board(kBoardText);
    Rigid3 moved = poses_[1];
    moved.translation.x() += 1.5;  // 2.4 px
    write_png(off(1), photograph(camera(), moved, board, {}));
    const Ended ended = run_stria(command(
        {on(0), on(1), on(2), on(3)}, {"--json", "--laser-off", off(0), off(1), off(2), off(3)}));
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(number_of(ended.out, "views_used"), 3);
    EXPECT_TRUE(has(ended.out, "moved between the pictures with and without laser")) << ended.out;
}

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <cstdio>
#include <random>
#include <string>

#include "host/io/model_io.h"
#include "host/io/whole_file.h"
#include "tests/calib/synthetic_board.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"

/// `stria calibrate camera` from a table of corners.
namespace stria {
namespace {

using test_support::Ended;
using test_support::has;
using test_support::run_stria;

/// Table "view row col x y weight" of a chessboard of 9 x 6 corners in `count` views.
std::string corner_table(int count) {
    const Board board = parse_board("chessboard:9x6:25");
    std::mt19937 rng(8);
    std::uniform_real_distribution<double> unit(-1, 1);
    std::string table = "# view row col x y weight\n";
    for (int view = 0; view < count;) {
        const Eigen::Vector3d centre(60 * unit(rng), 40 * unit(rng), 380 + 60 * unit(rng));
        const CameraView seen =
            seen_by(webcam(), random_board_pose(rng, board, centre, 0.7, 0.5), board, 0.1, rng);
        if (seen.ids.size() < 54) continue;
        for (std::size_t i = 0; i < seen.ids.size(); ++i) {
            char line[120];
            std::snprintf(line, sizeof line, "%d %d %d %.4f %.4f 1\n", view, seen.ids[i] / 9,
                          seen.ids[i] % 9, seen.pixels[i].x(), seen.pixels[i].y());
            table += line;
        }
        ++view;
    }
    return table;
}

Ended calibrate(const TemporaryFolder& folder, const std::string& model, int views) {
    write_whole_file(folder / "corners.txt", corner_table(views));
    return run_stria({"calibrate", "camera", "--corners", folder / "corners.txt", "--image-size",
                      "1280x960", "--board", "chessboard:9x6:25", "--model", model, "--json",
                      "--force", "--out", folder / "camera.toml"});
}

TEST(CalibrateCamera, ChoosesTheLensModelByViewsHeldOut) {
    const TemporaryFolder folder;
    const Ended ended = calibrate(folder, "auto", 12);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_TRUE(has(ended.out, "\"lens_trials\"")) << ended.out;
    EXPECT_TRUE(has(ended.err, "taken: brown5")) << ended.err;
    const CameraModel found = read_camera(folder / "camera.toml");
    EXPECT_EQ(found.kind, LensKind::brown5);
    EXPECT_NEAR(found.fx, 1000, 3);

    const Ended stated = calibrate(folder, "pinhole", 12);
    ASSERT_EQ(stated.code, 0) << stated.err;
    EXPECT_FALSE(has(stated.out, "lens_trials"));
    EXPECT_EQ(read_camera(folder / "camera.toml").kind, LensKind::pinhole);
}

TEST(CalibrateCamera, FewViewsChooseNoLensModel) {
    const TemporaryFolder folder;
    const Ended ended = calibrate(folder, "auto", 5);
    EXPECT_EQ(ended.code, 1);
    EXPECT_TRUE(has(ended.err, "expected more views")) << ended.err;
    EXPECT_THROW(read_camera(folder / "camera.toml"), std::exception);
}

}  // namespace
}  // namespace stria

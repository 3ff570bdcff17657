#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "calib/sheet_file.h"
#include "firmware/core/angle.h"
#include "tests/calib/sheet_error.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"

/// Twelve photographed placements of a circle grid with and without laser, and the plane that their
/// author's own program found in them.
namespace stria {
namespace {

using test_support::Ended;
using test_support::number_of;
using test_support::run_stria;
using Words = std::vector<std::string>;

const std::string kBoard = "circles:7x7:37.5";
const Eigen::Vector3d kAuthorsNormal = Eigen::Vector3d(-0.13052, -6.39595, 1).normalized();

Words photographs(const std::string& set, const std::string& stem) {
    Words files;
    for (int i = 0; i < 12; ++i) files.push_back(set + stem + std::to_string(i) + ".jpg");
    return files;
}

Words joined(std::initializer_list<Words> parts) {
    Words all;
    for (const Words& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

TEST(CalibrateSheetReal, AgreesWithTheAuthorsPlane) {
    const char* data = std::getenv("STRIA_TEST_DATA");
    if (!data) GTEST_SKIP() << "set STRIA_TEST_DATA to the folder of real data sets";
    const std::string set = std::string(data) + "/laser_plane_circlegrid/";
    const TemporaryFolder folder;
    const std::string lens = folder / "camera.toml", out = folder / "sheet.toml";
    const Words off = photographs(set, "calib"), on = photographs(set, "light");

    const Ended camera = run_stria(
        joined({{"calibrate", "camera"}, off, {"--board", kBoard, "--out", lens, "--json"}}));
    ASSERT_EQ(camera.code, 0) << camera.err;
    const Ended ended = run_stria(
        joined({{"calibrate", "sheet"},
                on,
                {"--board", kBoard, "--camera", lens, "--out", out, "--json", "--laser-off"},
                off}));
    ASSERT_EQ(ended.code, 0) << ended.err;
    const double turn = angle_rad(read_sheet(out).normal, kAuthorsNormal);
    std::cout << turn / kDegree << " deg from the author's plane; "
              << number_of(ended.out, "points_used") << " points of "
              << number_of(ended.out, "views_used") << " views, rms "
              << number_of(ended.out, "rms_mm") << " mm\n";
    EXPECT_LT(turn, 0.3 * kDegree);  // his points lie 0.54 mm (rms) off his plane
    const std::size_t last = ended.out.rfind("\"left_out_rms_mm\"");  // of all views together
    ASSERT_NE(last, std::string::npos);
    const double left_out = number_of(ended.out.substr(last), "left_out_rms_mm");
    std::cout << "each view against the sheet of the others: " << left_out << " mm rms\n";
    EXPECT_LT(left_out, 0.6);  // mm: his points' own 0.54; a centroid of red light gives 3.2
    EXPECT_EQ(number_of(ended.out, "views_used"), 12);
}

}  // namespace
}  // namespace stria

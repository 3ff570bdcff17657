#include "calib/sheet_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "calib/sheet_file.h"
#include "host/core/errors.h"
#include "host/io/whole_file.h"
#include "tests/calib/photographed_board.h"
#include "tests/calib/sheet_error.h"
#include "tests/calib/synthetic_board.h"
#include "tests/host/io/temporary_folder.h"

/// Corners and stripe peaks computed from a known sheet: what comes back is compared with it.
namespace stria {
namespace {

const FlatSheet kSheet = {Eigen::Vector3d(0.92, 0.03, 0.39).normalized(), 190};
constexpr double kCornerPx = 0.05, kStripePx = 0.1;

CameraModel camera() {
    CameraModel camera;
    camera.kind = LensKind::brown5;
    camera.width = 1280;
    camera.height = 1024;
    camera.fx = camera.fy = 1500;
    camera.cx = 640;
    camera.cy = 512;
    camera.distortion = {-0.1, 0.05, 3e-4, -2e-4, 0};
    return camera;
}

const Board kBoard = parse_board("chessboard:9x7:15");

/// Stripe points every half millimetre along the line in which sheet and board meet.
std::vector<StripePeak> peaks_on(const Rigid3& pose, const FlatSheet& sheet, double noise_px,
                                 std::mt19937& rng) {
    std::normal_distribution<double> noise(0, noise_px > 0 ? noise_px : 1e-12);
    const Eigen::Vector3d board_normal = pose.rotation.col(2);
    const Eigen::Vector3d along = sheet.normal.cross(board_normal).normalized();
    Eigen::Matrix3d planes;
    planes << sheet.normal.transpose(), board_normal.transpose(), along.transpose();
    const Eigen::Vector3d on_line =
        planes.inverse() * Eigen::Vector3d(sheet.offset_mm, board_normal.dot(pose.translation),
                                           along.dot(pose * Eigen::Vector3d(60, 45, 0)));
    std::vector<StripePeak> peaks;
    for (double t = -90; t <= 90; t += 0.5) {
        const auto pixel = project(camera(), on_line + t * along);
        if (!pixel || !camera().contains(*pixel)) continue;
        StripePeak peak{*pixel, std::max(noise_px, 1e-3), 1.5, Eigen::Vector2d::UnitX()};
        peak.pixel.x() += noise(rng);
        peaks.push_back(peak);
    }
    return peaks;
}

SheetView view_of(const Rigid3& pose, const FlatSheet& sheet, double corner_px, double stripe_px,
                  std::mt19937& rng, const std::string& name) {
    SheetView view;
    view.corners = seen_by(camera(), pose, kBoard, corner_px > 0 ? corner_px : 1e-12, rng);
    view.corners.name = name;
    view.peaks = {peaks_on(pose, sheet, stripe_px, rng)};
    return view;
}

/// Boards across the sheet, 380 to 560 mm away, tilted to all sides.
std::vector<SheetView> views_of(const FlatSheet& sheet, int count, double corner_px,
                                double stripe_px, std::mt19937& rng) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<SheetView> views;
    for (int i = 0; i < count; ++i) {
        const double z = 380 + 180.0 * i / (count - 1);
        const double x = (sheet.offset_mm - sheet.normal.z() * z) / sheet.normal.x();
        const Rigid3 pose =
            random_board_pose(rng, kBoard, {x + 8 * unit(rng), 10 * unit(rng), z}, 0.6, 0.3);
        views.push_back(
            view_of(pose, sheet, corner_px, stripe_px, rng, "view " + std::to_string(i)));
    }
    return views;
}

TEST(SheetCalibration, IsExactWithoutNoise) {
    std::mt19937 rng(3);
    const auto found = calibrate_sheet(views_of(kSheet, 5, 0, 0, rng), kBoard, camera());
    EXPECT_EQ(found.views_used, 5);
    EXPECT_LT((found.normal - kSheet.normal).norm(), 1e-6);  // rad: the pose solver's stopping
    EXPECT_NEAR(found.offset_mm, kSheet.offset_mm, 5e-4);    // mm
    EXPECT_LT(found.rms_mm, 5e-4);
}

TEST(SheetCalibration, ErrsAsItsCovarianceSays) {
    std::mt19937 rng(17);
    constexpr int kTrials = 30;
    double sum = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        const auto views = views_of(kSheet, 8, kCornerPx, kStripePx, rng);
        const auto found = calibrate_sheet(views, kBoard, camera());
        ASSERT_GE(found.views_used, 6);
        for (const SheetViewResult& view : found.views)  // a stripe along an edge of squares
            EXPECT_TRUE(view.rejected.empty() || view.rejected.find("stripe not crossing") == 0)
                << view.rejected;
        EXPECT_NEAR(found.corner_sigma_px, kCornerPx, 0.006);  // px, 1 / sqrt(2 dof), 5 sigma
        sum += sheet_chi_square(found.normal, found.offset_mm, found.covariance, kSheet);
    }
    // Mean of chi-square / 3 over the trials is 1, its sd sqrt(2 / (3 trials)): 4 sd either way,
    // and the ratio of lines to their own scatter that raises the covariance lowers it by <= 20 %.
    const double ratio = sum / (3.0 * kTrials), sd = std::sqrt(2.0 / (3.0 * kTrials));
    std::cout << "squared error over covariance: " << ratio << '\n';
    EXPECT_LT(ratio, 1 + 4 * sd);
    EXPECT_GT(ratio, 0.8 - 4 * sd);
}

TEST(SheetCalibration, LeavesOutStrayPeaksAndAMovedBoardAndSaysSo) {
    std::mt19937 rng(5);
    auto views = views_of(kSheet, 7, kCornerPx, kStripePx, rng);
    std::uniform_real_distribution<double> unit(0, 1);
    for (SheetView& view : views)
        for (int i = 0; i < 60; ++i)  // reflections, anywhere
            view.peaks[0].push_back(
                {{1279 * unit(rng), 1023 * unit(rng)}, 0.05, 1.5, Eigen::Vector2d::UnitX()});
    const FlatSheet moved = {kSheet.normal, kSheet.offset_mm + 4};
    const Rigid3 pose = board_at(kBoard, {20, 0, 430}, {0.3, 0.2, 0});
    views[3] = view_of(pose, moved, kCornerPx, kStripePx, rng, "moved one");
    const auto found = calibrate_sheet(views, kBoard, camera());
    EXPECT_EQ(found.views_used, 6);
    EXPECT_NE(found.views[3].rejected.find("did board, camera or laser move"), std::string::npos)
        << found.views[3].rejected;
    EXPECT_LT(sheet_chi_square(found.normal, found.offset_mm, found.covariance, kSheet),
              25);                          // 3 degrees of freedom: beyond 1 in 1e4
    EXPECT_LT(found.left_out_rms_mm, 0.2);  // mm: 0.1 px at 450 mm and 23 deg is 0.08
}

/// The message of the error it throws; empty if it does not.
std::string refusal_of(const std::vector<SheetView>& views, const CameraModel& seen_with) {
    try {
        calibrate_sheet(views, kBoard, seen_with);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(SheetCalibration, NamesWhatCannotBeSolved) {
    std::mt19937 rng(8);
    const auto views = views_of(kSheet, 4, kCornerPx, kStripePx, rng);
    EXPECT_NE(refusal_of({views[0]}, camera()).find("at least 2 placements"), std::string::npos);
    EXPECT_NE(refusal_of({}, camera()).find("at least 2 placements"), std::string::npos);

    // Parallel boards in one plane, shifted along the stripe.
    std::vector<SheetView> one_line;
    for (int i = 0; i < 5; ++i)
        one_line.push_back(view_of(board_at(kBoard, {0, 3.0 * i, 450}, {0, 0, 0}), {{1, 0, 0}, 12},
                                   kCornerPx, kStripePx, rng, "same"));
    EXPECT_NE(refusal_of(one_line, camera()).find("nearly on one line"), std::string::npos)
        << refusal_of(one_line, camera());

    const FlatSheet through_camera = {Eigen::Vector3d(1, 0.02, 0).normalized(), 1.5};
    const std::string along_it =
        refusal_of(views_of(through_camera, 5, kCornerPx, kStripePx, rng), camera());
    EXPECT_NE(along_it.find("from the camera's centre"), std::string::npos) << along_it;

    CameraModel nan = camera();
    nan.fx = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NE(refusal_of(views, nan).find("fx"), std::string::npos);
}

TEST(SheetCalibration, SaysWhyAViewHasNoStripe) {
    std::mt19937 rng(8);
    auto views = views_of(kSheet, 6, kCornerPx, kStripePx, rng);
    views[0].peaks.clear();
    views[1].peaks[0].resize(8);
    auto& short_one = views[2].peaks[0];  // ends after a fifth of the board
    std::erase_if(short_one, [&](const StripePeak& p) {
        return (p.pixel - short_one[short_one.size() / 2].pixel).norm() > 35;
    });
    views[3].corners.ids.resize(3);
    views[3].corners.pixels.resize(3);
    const auto found = calibrate_sheet(views, kBoard, camera());
    EXPECT_EQ(found.views_used, 2);
    for (int i : {0, 1, 2})
        EXPECT_EQ(found.views[static_cast<std::size_t>(i)].rejected.find("stripe not crossing"), 0u)
            << i << ": " << found.views[static_cast<std::size_t>(i)].rejected;
    EXPECT_EQ(found.views[3].rejected.find("too few corners"), 0u) << found.views[3].rejected;
}

TEST(SheetFile, ReadsBackBitByBitAndRefusesWhatIsNoSheet) {
    std::mt19937 rng(3);
    const auto found = calibrate_sheet(views_of(kSheet, 4, 0.05, 0.1, rng), kBoard, camera());
    const MeasuredSheet sheet = {camera(), found.normal, found.offset_mm, found.covariance};
    const TemporaryFolder folder;
    write_sheet(folder / "sheet.toml", sheet);
    const MeasuredSheet back = read_sheet(folder / "sheet.toml");
    EXPECT_EQ(back.normal, sheet.normal);
    EXPECT_EQ(back.offset_mm, sheet.offset_mm);
    EXPECT_EQ(back.covariance, sheet.covariance);
    EXPECT_EQ(format_sheet(back), format_sheet(sheet));

    const std::string text = format_sheet(sheet);
    const auto with = [&](const std::string& key, const std::string& value) {
        const auto from = text.find("\n" + key + " = ") + 1;
        return text.substr(0, from) + key + " = " + value + text.substr(text.find('\n', from));
    };
    for (const std::string& bad :
         {with("normal", "[1.0, 1.0, 0.0]"), with("offset_mm", "-3.0"), with("offset_mm", "nan"),
          with("fx", "nan"), text + "more = 1\n", text.substr(0, text.size() / 2)})
        EXPECT_THROW(parse_sheet(bad, "sheet.toml"), Error) << bad;
}

}  // namespace
}  // namespace stria

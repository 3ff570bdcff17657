#include <gtest/gtest.h>

#include <iostream>
#include <string>
#include <vector>

#include "calib/sheet_file.h"
#include "firmware/core/angle.h"
#include "host/core/frame_image.h"
#include "host/io/image_io.h"
#include "host/io/model_io.h"
#include "host/local/local_scanner.h"
#include "tests/calib/sheet_error.h"
#include "tests/host/cli/run_stria.h"
#include "tests/host/io/temporary_folder.h"
#include "tests/support/machine_scenes.h"

/// Grey pictures of a board that the simulator's camera takes, its laser on and off, at rest: the
/// sheet found in them against the simulated one.
namespace stria {
namespace {

using test_support::Ended;
using test_support::has;
using test_support::machine_scenes;
using test_support::number_of;
using test_support::run_stria;

/// One exposure for both pictures, and next to no travel: 0.01 mm during an exposure.
ScanPlan pictures_at_rest() {
    ScanPlan plan;
    plan.mode = StripeMode::spatial;
    plan.from = -0.02;
    plan.to = 0.02;
    plan.step = 0.02;
    plan.off_frames = 1;
    plan.record = RecordWhat::frames;
    return plan;
}

class CalibrateSheetSimulated : public testing::Test {
  protected:
    void SetUp() override {
        auto scenes = machine_scenes(MachineKind::rail, 6);
        board_ = scenes.board;
        scene_ = scenes.board_scene;
        scene_.ambient_level = 0.35;  // bright enough to see the board beside the stripe
        scene_.axis.sigma = 1e-5;
        scene_.laser_power_mw = 6;
        write_camera(folder_ / "camera.toml", scene_.channel.camera);
        OpenOptions options;
        options.seed = 3;
        LocalScanner scanner(scene_, options);
        for (int view = 0; view < static_cast<int>(scene_.views.size()); view += 2) {
            scanner.scanner().set_view(view);
            const RecordingContents taken = scanner.run(pictures_at_rest());
            ASSERT_EQ(taken.off_frames.size(), 1u);
            ASSERT_FALSE(taken.frames.empty()) << taken.end->reason;
            save(taken.off_frames[0], "off" + std::to_string(view), off_);
            save(taken.frames[0], "on" + std::to_string(view), on_);
        }
    }

    void save(const Frame& frame, const std::string& name, std::vector<std::string>& files) {
        const Grey16Image wide = image_from_frame(frame);
        GreyImage image(wide.width, wide.height);
        for (std::size_t i = 0; i < image.values.size(); ++i)
            image.values[i] = static_cast<std::uint8_t>(wide.values[i]);
        write_png(files.emplace_back(folder_ / (name + ".png")), image);
    }

    TemporaryFolder folder_;
    Board board_;
    Scene scene_;
    std::vector<std::string> on_, off_;
};

TEST_F(CalibrateSheetSimulated, FindsTheSheetAsWellAsItSays) {
    const std::string out = folder_ / "sheet.toml";
    std::vector<std::string> words = {"calibrate", "sheet"};
    words.insert(words.end(), on_.begin(), on_.end());
    words.insert(words.end(), {"--board", to_string(board_), "--camera", folder_ / "camera.toml",
                               "--out", out, "--json"});
    const Ended alone = run_stria(words);  // a grey board is not told from a grey stripe
    EXPECT_EQ(alone.code, 1);
    EXPECT_TRUE(has(alone.err, "expected --laser-off pictures")) << alone.err;

    words.push_back("--laser-off");
    words.insert(words.end(), off_.begin(), off_.end());
    const Ended ended = run_stria(words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    const MeasuredSheet sheet = read_sheet(out);
    const LaserSheet& laser = scene_.channel.sheet;
    const FlatSheet truth = {laser.normal, laser.offset_mm};
    const double turn = angle_rad(sheet.normal, truth.normal);
    const double error = sheet_chi_square(sheet.normal, sheet.offset_mm, sheet.covariance, truth);
    std::cout << turn / kDegree << " deg (sigma " << number_of(ended.out, "turn_rad") / kDegree
              << "), offset " << sheet.offset_mm - truth.offset_mm << " mm, rms "
              << number_of(ended.out, "rms_mm") << " mm over "
              << number_of(ended.out, "points_used") << " points, chi-square " << error
              << " of 3\n";
    EXPECT_EQ(number_of(ended.out, "views_used"), static_cast<double>(on_.size()));
    EXPECT_LT(error, 16.27);  // 0.1 % quantile of chi-square with 3 degrees of freedom
    EXPECT_LT(turn, 0.02 * kDegree);
    EXPECT_LT(number_of(ended.out, "rms_mm"), 0.05);  // mm: 0.1 px is 0.03 mm here
}

}  // namespace
}  // namespace stria

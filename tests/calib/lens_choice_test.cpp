#include "calib/lens_choice.h"

#include <gtest/gtest.h>

#include <iostream>

#include "host/core/errors.h"
#include "tests/calib/synthetic_board.h"

namespace stria {
namespace {

/// The webcam, with or without distortion, and a lens of 105 deg that five coefficients do not
/// follow.
CameraModel lens_of(LensKind kind) {
    CameraModel camera = with_lens(webcam(), kind);
    if (kind != LensKind::rational8) return camera;
    camera.fx = camera.fy = 490;
    camera.distortion = {2.1, 0.65, 2e-4, -1e-4, 0.02, 2.4, 1.25, 0.12};
    return camera;
}

/// Boards all over the image, some of them at its corners.
std::vector<CameraView> views_of(const CameraModel& camera, const Board& board, int count,
                                 std::mt19937& rng) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<CameraView> views;
    while (static_cast<int>(views.size()) < count) {
        const Eigen::Vector2d pixel(640 + 560 * unit(rng), 480 + 420 * unit(rng));
        const Eigen::Vector3d ray = ray_through(camera, pixel);
        CameraView view = seen_by(
            camera, random_board_pose(rng, board, (320 + 80 * unit(rng)) * ray / ray.z(), 0.7),
            board, 0.1, rng);
        view.name = "view " + std::to_string(views.size());
        if (view.ids.size() >= 30) views.push_back(std::move(view));
    }
    return views;
}

TEST(LensChoice, TakesTheModelThatIsThere) {
    const Board board = parse_board("charuco:11x9:20:15:DICT_5X5_250");  // parts of it count
    constexpr int kSeeds = 3;
    for (const LensKind truth : {LensKind::pinhole, LensKind::brown5, LensKind::rational8}) {
        int right = 0;
        for (unsigned seed = 1; seed <= kSeeds; ++seed) {
            std::mt19937 rng(seed);
            const CameraModel camera = lens_of(truth);
            const LensChoice choice =
                choose_lens(views_of(camera, board, 18, rng), board, camera.width, camera.height);
            right += choice.lens == truth;
            ASSERT_EQ(choice.trials.size(), 3U);
            std::cout << name_of(truth) << " seed " << seed << ": " << name_of(choice.lens);
            for (const LensTrial& trial : choice.trials)
                std::cout << ", " << trial.held_out_rms_px << " (" << trial.worse_by_log << " +- "
                          << trial.worse_by_sigma_log << ")" << trial.failed;
            std::cout << std::endl;
            if (truth == LensKind::rational8) continue;  // 12 views extrapolate to the corners
            // 0.1 px a coordinate is 0.141 px of a corner; poses fitted.
            EXPECT_NEAR(choice.trials[static_cast<std::size_t>(truth)].held_out_rms_px, 0.139,
                        0.005);
        }
        EXPECT_GE(right, kSeeds - 1) << name_of(truth);  // 2 standard errors: 1 of 44 by chance
    }
}

TEST(LensChoice, IsNotMovedByCornersThatAreWrong) {
    const Board board = parse_board("charuco:11x9:20:15:DICT_5X5_250");
    std::mt19937 rng(3);
    const CameraModel camera = lens_of(LensKind::brown5);
    auto views = views_of(camera, board, 18, rng);
    for (std::size_t v = 0; v < views.size(); v += 4) views[v].pixels[7].x() += 9;
    const LensChoice choice = choose_lens(views, board, camera.width, camera.height);
    EXPECT_EQ(choice.lens, LensKind::brown5);
    EXPECT_NEAR(choice.trials[1].held_out_rms_px, 0.139, 0.006);
}

TEST(LensChoice, NeedsSixViews) {
    const Board board = parse_board("charuco:11x9:20:15:DICT_5X5_250");
    std::mt19937 rng(4);
    const CameraModel camera = lens_of(LensKind::brown5);
    const auto views = views_of(camera, board, 5, rng);
    EXPECT_THROW(choose_lens(views, board, camera.width, camera.height), Error);
}

TEST(LensChoice, AnotherLensModelDropsWhatItLacks) {
    const CameraModel camera = with_lens(lens_of(LensKind::rational8), LensKind::brown5);
    EXPECT_EQ(camera.kind, LensKind::brown5);
    EXPECT_EQ(camera.distortion[4], 0.02);
    EXPECT_EQ(camera.distortion[5], 0);
    EXPECT_EQ(validate(camera), "");
}

}  // namespace
}  // namespace stria

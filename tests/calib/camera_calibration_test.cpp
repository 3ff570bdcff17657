#include "calib/camera_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "host/core/errors.h"
#include "tests/calib/synthetic_board.h"

namespace stria {
namespace {

CameraModel truth_camera(LensKind kind) {
    CameraModel camera;
    camera.kind = kind;
    camera.width = 1280;
    camera.height = 1024;
    camera.fx = 1503.2;
    camera.fy = 1499.7;
    camera.cx = 651.1;
    camera.cy = 502.8;
    if (kind != LensKind::pinhole) camera.distortion = {-0.11, 0.08, 6e-4, -4e-4, -0.02};
    if (kind == LensKind::rational8) camera.distortion = {0.3, 0.1, 6e-4, -4e-4, 0.01, 0.42, 0.05};
    return camera;
}

std::vector<CameraView> random_views(const CameraModel& camera, const Board& board, int count,
                                     double noise_px, std::mt19937& rng) {
    std::uniform_real_distribution<double> unit(-1, 1);
    std::vector<CameraView> views;
    for (int i = 0; i < count; ++i) {
        const Eigen::Vector3d centre(80 * unit(rng), 60 * unit(rng), 450 + 120 * unit(rng));
        views.push_back(
            seen_by(camera, random_board_pose(rng, board, centre, 0.7), board, noise_px, rng));
        views.back().name = "view " + std::to_string(i);
    }
    return views;
}

TEST(CameraCalibration, FindsTheTruthWithinItsOwnSigmaAsADistribution) {
    const Board board = parse_board("chessboard:11x8:20");
    for (LensKind kind : {LensKind::pinhole, LensKind::brown5}) {
        const CameraModel truth = truth_camera(kind);
        std::mt19937 rng(11);
        double chi_square = 0, dof = 0;
        const int trials = 14;
        for (int trial = 0; trial < trials; ++trial) {
            const auto views = random_views(truth, board, 12, 0.1, rng);
            const auto found =
                calibrate_camera(views, board, truth.width, truth.height, {.lens = kind});
            ASSERT_TRUE(found.converged);
            EXPECT_EQ(found.views_used, 12);
            EXPECT_NEAR(found.sigma_pixel, 0.1, 0.012);  // px, 1 / sqrt(2 dof), 5 sigma
            Eigen::VectorXd error(found.covariance.rows());
            error.head<4>() << found.camera.fx - truth.fx, found.camera.fy - truth.fy,
                found.camera.cx - truth.cx, found.camera.cy - truth.cy;
            for (int i = 0; i + 4 < error.size(); ++i)
                error[4 + i] = found.camera.distortion[static_cast<std::size_t>(i)] -
                               truth.distortion[static_cast<std::size_t>(i)];
            chi_square += error.dot(found.covariance.ldlt().solve(error));
            dof += static_cast<double>(error.size());
        }
        // Sum of squared whitened errors: chi-square, mean dof, sd sqrt(2 dof); 4 sd either way.
        EXPECT_NEAR(chi_square / dof, 1.0, 4 * std::sqrt(2.0 / dof)) << name_of(kind);
    }
}

TEST(CameraCalibration, IsExactWithoutNoise) {
    const Board board = parse_board("charuco:12x9:15:11:DICT_5X5_100");
    for (LensKind kind : {LensKind::pinhole, LensKind::brown5, LensKind::rational8}) {
        const CameraModel truth = truth_camera(kind);
        std::mt19937 rng(3);
        const auto views = random_views(truth, board, 10, 0, rng);
        const auto found =
            calibrate_camera(views, board, truth.width, truth.height, {.lens = kind});
        EXPECT_LT(found.rms_px, 1e-4) << name_of(kind);  // px, the solver's tolerance
        EXPECT_NEAR(found.camera.fx, truth.fx, 0.01) << name_of(kind);
    }
}

TEST(CameraCalibration, LeavesOutBadPointsAndViewsAndSaysSo) {
    const Board board = parse_board("chessboard:9x6:25");
    const CameraModel truth = truth_camera(LensKind::brown5);
    std::mt19937 rng(5);
    auto views = random_views(truth, board, 10, 0.05, rng);
    views[2].pixels[17] += Eigen::Vector2d(30, -12);
    for (std::size_t i = 0; i < views[4].pixels.size(); i += 2)
        views[4].pixels[i] += Eigen::Vector2d(40.0 * std::sin(double(i)), 25);
    views[6].ids.resize(5);
    views[6].pixels.resize(5);
    const auto found = calibrate_camera(views, board, truth.width, truth.height);
    EXPECT_EQ(found.views_used, 8);
    ASSERT_EQ(found.views[2].ids_rejected.size(), 1u);
    EXPECT_EQ(found.views[2].ids_rejected[0], views[2].ids[17]);
    EXPECT_FALSE(found.views[4].rejected.empty());
    EXPECT_NE(found.views[6].rejected.find("too few"), std::string::npos);
    EXPECT_NEAR(found.camera.fx, truth.fx, 5 * std::sqrt(found.covariance(0, 0)));
}

TEST(CameraCalibration, RefusesViewsThatCannotTell) {
    const Board board = parse_board("chessboard:9x6:25");
    const CameraModel truth = truth_camera(LensKind::pinhole);
    std::mt19937 rng(5);
    EXPECT_THROW(calibrate_camera(random_views(truth, board, 2, 0.05, rng), board, truth.width,
                                  truth.height),
                 Error);
    CameraView bad = seen_by(truth, random_board_pose(rng, board, {0, 0, 500}, 0.3), board, 0, rng);
    bad.ids[0] = 54;
    EXPECT_THROW(calibrate_camera({bad, bad, bad}, board, 1280, 1024), std::invalid_argument);
}

TEST(CameraCalibration, RefusesABoardThatIsAlwaysParallel) {
    const Board board = parse_board("chessboard:9x6:25");
    const CameraModel truth = truth_camera(LensKind::pinhole);
    for (unsigned seed = 0; seed < 20; ++seed) {
        std::mt19937 rng(seed);
        std::vector<CameraView> views;
        for (int i = 0; i < 8; ++i) {
            const Eigen::Vector3d centre(10.0 * i - 35, 5.0 * i, 450.0 + 20 * i);
            views.push_back(
                seen_by(truth, random_board_pose(rng, board, centre, 0), board, 0.1, rng));
        }
        EXPECT_THROW(calibrate_camera(views, board, truth.width, truth.height), Error) << seed;
    }
}

TEST(CameraCalibration, SolvesABulgingBoard) {
    const Board board = parse_board("chessboard:10x10:20");
    const CameraModel truth = truth_camera(LensKind::brown5);
    std::mt19937 rng(8);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto points = board_points(board);
    std::vector<CameraView> views;
    for (int v = 0; v < 15; ++v) {
        const Rigid3 pose = random_board_pose(
            rng, board, {60 * unit(rng), 40 * unit(rng), 480 + 100 * unit(rng)}, 0.7);
        CameraView view;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double gx = points[i].x() / 90 - 1, gy = points[i].y() / 90 - 1;
            const Eigen::Vector3d bulged(points[i].x(), points[i].y(),
                                         0.4 * (1 - gx * gx) - 0.25 * (1 - gy * gy));
            view.ids.push_back(static_cast<int>(i));
            view.pixels.push_back(*project(truth, pose * bulged));
        }
        views.push_back(view);
    }
    const auto found = calibrate_camera(views, board, truth.width, truth.height,
                                        {.lens = LensKind::brown5, .board_warp = true});
    EXPECT_NEAR(found.board_warp_mm.x(), 0.4, 1e-3);  // mm, noise free
    EXPECT_NEAR(found.board_warp_mm.y(), -0.25, 1e-3);
    EXPECT_NEAR(found.camera.fx, truth.fx, 0.05);
}

}  // namespace
}  // namespace stria

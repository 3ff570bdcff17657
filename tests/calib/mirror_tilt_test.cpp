#include "calib/mirror_tilt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "calib/calibration_warnings.h"
#include "tests/calib/linearised_calibration.h"
#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

double tilt_of(const ScannerProblem& problem) {
    const MirrorAxis& mirror = problem.channels()[0].axis.mirror;
    return std::asin(mirror.normal0.dot(mirror.direction));
}

/// A machine whose stripes, free of noise but weighted as if they had some, have two solutions.
class TwoSolutions : public testing::Test {
  protected:
    TwoSolutions() {
        std::mt19937 rng(11);
        truth_ = built_scanner(drawn_scanner(MachineKind::swept), rng);
        SyntheticOptions options;
        options.views = 12;
        options.max_tilt_rad = 0.611;
        options.pixel_step = 16;
        options.noisy = false;
        views_ = synthetic_views(truth_, board_, options, rng, &poses_);
    }
    ScannerProblem at_truth() const {
        return problem_at_truth(truth_, board_, views_, poses_, 0.05,
                                {.stripe_points_per_view = 100});
    }

    const Board board_ = parse_board("chessboard:12x9:22");
    ScannerModel truth_;
    std::vector<Rigid3> poses_;
    std::vector<CornerView> views_;
};

/// The problem with m0 tilted towards the axis and everything else made to follow.
ScannerProblem solved_from_tilt(ScannerProblem problem, double by_rad) {
    const CameraModel camera = problem.channels()[0].camera;
    AxisModel axis = problem.channels()[0].axis;
    Eigen::Vector3d& m0 = axis.mirror.normal0;
    m0 = (m0 + std::tan(by_rad) * axis.mirror.direction).normalized();
    problem.set_camera_and_axis(camera, axis);
    ScannerProblem::Stage stage = problem.everything();
    stage.camera = stage.corners = false;
    stage.axis_free = {0, 1, 2, 3, 6, 7, 8};
    problem.solve(stage);
    stage.axis_free = problem.everything().axis_free;
    problem.solve(stage);
    problem.solve(problem.everything());
    return problem;
}

TEST_F(TwoSolutions, TheFalseOneIsLeft) {
    ScannerProblem problem = solved_from_tilt(at_truth(), 0.1);
    const ScannerProblem::Stage all = problem.everything();
    const double cost = problem.cost(all), tilt = tilt_of(at_truth());
    ASSERT_GT(cost, 1);  // half the chi-square: it is a minimum, but a false one
    ASSERT_GT(std::abs(tilt_of(problem) - tilt), 0.1);
    const OtherMirror other = take_better_mirror(problem, all, 0.1);
    EXPECT_TRUE(other.taken);
    EXPECT_NEAR(other.margin, cost, 0.02);
    EXPECT_NEAR(tilt_of(problem), tilt, 1e-3);
    EXPECT_LT(problem.cost(all), 0.01);
}

TEST_F(TwoSolutions, TheTrueOneIsKept) {
    ScannerProblem problem = at_truth();
    const ScannerProblem::Stage all = problem.everything();
    problem.solve(all);
    const OtherMirror other = take_better_mirror(problem, all, 0.1);
    EXPECT_FALSE(other.taken);
    EXPECT_GT(other.margin, 1);
    EXPECT_NEAR(tilt_of(problem), tilt_of(at_truth()), 1e-3);
}

TEST(OtherMirror, IsSpokenOfWhereItFitsAlmostAlike) {
    EXPECT_EQ(alike_mirrors(OtherMirror().margin), "");  // there is none
    EXPECT_EQ(alike_mirrors(2), "");                     // 2 sigma apart
    EXPECT_NE(alike_mirrors(1.5).find("half chi-square 1.5 apart"), std::string::npos);
}

TEST(OtherMirror, IsNotLookedForOnOtherMachines) {
    ScannerProblem problem(parse_board("chessboard:12x9:22"),
                           drawn_scanner(MachineKind::rail).channels, {});
    EXPECT_FALSE(take_better_mirror(problem, problem.everything(), 0.1).taken);
}

}  // namespace
}  // namespace stria

#include "calib/coach.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <iostream>

#include "calib/cross_validation.h"
#include "calib/point_moves.h"
#include "host/core/errors.h"
#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

/// 12 x 9 corners with markers: synthetic views hold parts of boards, which only markers tell.
const char* const kBoard = "charuco:13x10:22:16:DICT_5X5_250";

SyntheticOptions quick_views(MachineKind kind) {
    SyntheticOptions options;
    options.pixel_step = 24;
    options.frames = 40;
    if (kind != MachineKind::swept) options.pictures = 3;
    return options;
}

/// The plan of the synthetic views, whose pictures show corners to 0.05 px.
CoachOptions coach_options(MachineKind kind) {
    CoachOptions options;
    const double to = kind == MachineKind::rail ? 120 : kind == MachineKind::swept ? 0.16 : 0.7;
    options.plan.sweep_from = -to;
    options.plan.sweep_to = to;
    options.plan.picture_s =
        kind == MachineKind::swept ? std::vector<double>{-to} : std::vector<double>{-to, 0, to};
    options.plan.corner_sigma_px = 0.05;
    options.plan.stripe_sigma_px = 0.1;
    if (kind == MachineKind::swept) options.mode = StripeMode::spacetime;
    return options;
}

/// Views where the coach asks for them, the board held 5 mm and 3 deg beside.
std::vector<CornerView> guided_views(Coach& coach, const ScannerModel& truth, const Board& board,
                                     const SyntheticOptions& options, int count,
                                     std::mt19937& rng) {
    std::normal_distribution<double> unit(0, 1);
    std::vector<CornerView> views;
    for (int i = 0; i < count; ++i) {
        const Rigid3 wanted = coach.advise().camera_from_board;
        Vector6d slip;
        for (int k = 0; k < 6; ++k) slip[k] = (k < 3 ? 0.05 : 5.0) * unit(rng);
        const Rigid3 about{Eigen::Matrix3d::Identity(), wanted.translation};
        views.push_back(synthetic_view(truth, board,
                                       about * rigid_from_vector(slip) * about.inverse() * wanted,
                                       "guided " + std::to_string(i), options, rng));
        coach.take(views.back());
    }
    return views;
}

class CoachOf : public testing::TestWithParam<MachineKind> {};

TEST_P(CoachOf, HasTheSolversInformation) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    std::mt19937 rng(5);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions options = quick_views(GetParam());
    options.views = 8;
    const auto views = synthetic_views(truth, board, options, rng);
    const ScannerCalibration solved =
        calibrate_scanner(views, board, drawn, {.stripe_points_per_view = 100});
    // The same rows by two codes: ours by differences, the solver's by dual numbers. In the modes
    // of the solver's covariance all that the views hold and the priors add up to 1.
    const Eigen::MatrixXd modes = covariance_modes(solved.model.covariance);
    EXPECT_LT((modes * modes.transpose() - solved.model.covariance).norm(),
              1e-6 * solved.model.covariance.norm());
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(modes.cols(), modes.cols());
    for (const CornerView& view : views)
        sum += information_of(
            view_rows(solved.model, modes,
                      measured_view(solved.model, board, view, solved.corner_sigma_px,
                                    solved.stripe_sigma_factor, 100)));
    const Eigen::VectorXd shares =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(sum).eigenvalues();
    std::cout << name_of(GetParam()) << ": " << shares.transpose() << std::endl;
    EXPECT_GT(shares.minCoeff(), -1e-6);
    // A few stripe points and corners are chosen otherwise: 1 in 20 at most.
    EXPECT_NEAR(shares.maxCoeff(), 1, 0.1);
    EXPECT_NEAR(shares[shares.size() / 2], 1, 0.1);
}

TEST_P(CoachOf, ProposesViewsThatHelpAndSaysWhere) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    std::mt19937 rng(6);
    const ScannerModel truth = built_scanner(drawn, rng);
    Coach coach(board, drawn, coach_options(GetParam()));
    const double before = coach.sigma_mm();
    const CoachAdvice advice = coach.advise();
    EXPECT_DOUBLE_EQ(advice.sigma_now_mm, before);
    EXPECT_LT(advice.sigma_then_mm, before);
    EXPECT_FALSE(advice.weakest.empty());
    EXPECT_NE(advice.text.find("mm away"), std::string::npos) << advice.text;
    guided_views(coach, truth, board, quick_views(GetParam()), 1, rng);
    // The board is not quite where it was asked for, and the machine not quite as drawn.
    EXPECT_LT(coach.sigma_mm(), 0.5 * (before + advice.sigma_then_mm));
    const std::string svg = coach.picture(coach.advise());
    EXPECT_EQ(svg.find("<svg"), 0U);
    EXPECT_NE(svg.find("</svg>"), std::string::npos);
    EXPECT_NE(svg.find("<circle"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST_P(CoachOf, GuidedViewsTeachMoreThanRandomOnes) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    std::mt19937 rng(7);
    const ScannerModel truth = built_scanner(drawn, rng);
    SyntheticOptions options = quick_views(GetParam());
    options.views = 6;
    Coach guided(board, drawn, coach_options(GetParam()));
    guided_views(guided, truth, board, options, options.views, rng);
    Coach random(board, drawn, coach_options(GetParam()));
    for (const CornerView& view : synthetic_views(truth, board, options, rng)) random.take(view);
    std::cout << name_of(GetParam()) << ": " << guided.sigma_mm() << " mm by 6 guided views, "
              << random.sigma_mm() << " mm by 6 random ones" << std::endl;
    EXPECT_LT(guided.sigma_mm(), random.sigma_mm());
}

TEST_P(CoachOf, ABoardWithoutMarkersStaysWhollyInThePicture) {
    const Board board = parse_board("chessboard:9x6:22");
    const ScannerModel drawn = drawn_scanner(GetParam());
    CoachOptions options = coach_options(GetParam());
    options.plan.picture_s = {0};
    const Coach coach(board, drawn, options);
    const Channel& channel = drawn.channels.front();
    const Rigid3 pose = board_motion(channel, 0) * coach.advise().camera_from_board;
    for (const Eigen::Vector3d& corner :
         {Eigen::Vector3d(-22, -22, 0), Eigen::Vector3d(198, -22, 0), Eigen::Vector3d(-22, 132, 0),
          Eigen::Vector3d(198, 132, 0)}) {
        const auto pixel = project(channel.camera, pose * corner);
        ASSERT_TRUE(pixel);
        EXPECT_TRUE(channel.camera.contains(*pixel)) << pixel->transpose();
    }
}

TEST_P(CoachOf, DoesNotCountAViewThatItIsOnlyAskedAbout) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    std::mt19937 rng(9);
    SyntheticOptions options = quick_views(GetParam());
    options.views = 1;
    CornerView view = synthetic_views(built_scanner(drawn, rng), board, options, rng).front();
    Coach coach(board, drawn, coach_options(GetParam()));
    const double before = coach.sigma_mm();
    EXPECT_TRUE(coach.can_use(view));
    EXPECT_EQ(coach.sigma_mm(), before);
    EXPECT_TRUE(coach.take(view));
    EXPECT_LT(coach.sigma_mm(), before);
    view.corners.clear();
    EXPECT_FALSE(coach.can_use(view));
}

TEST_P(CoachOf, NeverAsksAgainForWhatFailed) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    Coach coach(board, drawn, coach_options(GetParam()));
    const Rigid3 first = coach.advise().camera_from_board;
    coach.avoid(first);
    const Rigid3 second = coach.advise().camera_from_board;
    EXPECT_GT((second.translation - first.translation).norm() +
                  100 * (second.rotation - first.rotation).norm(),
              10);
}

#ifdef STRIA_GUIDED_VIEWS  // the long program
TEST_P(CoachOf, FewGuidedViewsReachWhatManyRandomOnesReach) {
    const Board board = parse_board(kBoard);
    const ScannerModel drawn = drawn_scanner(GetParam());
    double guided_squares = 0, random_squares = 0;
    const int seeds = STRIA_COACH_SEEDS;
    for (int seed = 1; seed <= seeds; ++seed) {
        std::mt19937 rng(40U + static_cast<unsigned>(seed));
        const ScannerModel truth = built_scanner(drawn, rng);
        SyntheticOptions options = quick_views(GetParam());
        Coach coach(board, drawn, coach_options(GetParam()));
        const auto guided = guided_views(coach, truth, board, options, STRIA_GUIDED_VIEWS, rng);
        options.views = STRIA_RANDOM_VIEWS;
        const auto random = synthetic_views(truth, board, options, rng);
        const ScannerCalibrationOptions solve{.stripe_points_per_view = 100};
        const auto by_guided = calibrate_scanner(guided, board, drawn, solve);
        const auto by_random = calibrate_scanner(random, board, drawn, solve);
        // Over the working volume: what either set of views has seen of it is its own affair.
        const Channel& channel = truth.channels.front();
        const ViewPlan plan = coach_options(GetParam()).plan;
        const Eigen::Vector2d range = working_distance_mm(channel, plan.sweep_from, plan.sweep_to);
        const auto volume =
            field_samples(channel, plan.sweep_from, plan.sweep_to, range[0], range[1]);
        const double guided_mm = predict_sigma(by_guided.model, volume).rms_mm;
        const double random_mm = predict_sigma(by_random.model, volume).rms_mm;
        const auto where_random = pulse_samples(random, truth);
        std::cout << name_of(GetParam()) << " seed " << seed << ": predicted " << guided_mm
                  << " mm by " << guided.size() << " guided views, " << random_mm << " mm by "
                  << random.size() << " random ones; where the random ones were "
                  << predict_sigma(by_guided.model, where_random).rms_mm << " and "
                  << predict_sigma(by_random.model, where_random).rms_mm << ", true error there "
                  << point_error(truth, by_guided.model, random).rms_mm << " and "
                  << point_error(truth, by_random.model, random).rms_mm << " mm" << std::endl;
        guided_squares += guided_mm * guided_mm;
        random_squares += random_mm * random_mm;
    }
    EXPECT_LE(guided_squares, random_squares);
}
#endif

TEST(Coach, RefusesAPlanThatNeverMeetsTheField) {
    const ScannerModel drawn = drawn_scanner(MachineKind::swept);
    CoachOptions options = coach_options(MachineKind::swept);
    options.near_mm = 5000;
    options.far_mm = 5001;
    EXPECT_THROW(Coach(parse_board(kBoard), drawn, options), Error);
    options = coach_options(MachineKind::swept);
    const Coach coach(parse_board("chessboard:12x9:200"), drawn, options);  // 2.4 m wide
    EXPECT_THROW(coach.advise(), Error);
}

TEST(Coach, SaysPlacesInWords) {
    const CameraModel camera = drawn_scanner(MachineKind::rail).channels[0].camera;
    const Board board = parse_board(kBoard);
    const auto points = board_points(board);
    const Eigen::Vector3d middle = 0.5 * (points.front() + points.back());
    const auto at = [&](const Eigen::Vector3d& place, const Eigen::Vector3d& turn) {
        const Eigen::Matrix3d rotation = rotation_from_vector(turn);
        return describe_placement(camera, board, {rotation, place - rotation * middle});
    };
    EXPECT_EQ(at({0, 0, 500}, {0, 0, 0}),
              "500 mm away, in the middle of the image, facing the camera");
    // Turned about y (down) by +0.52: x of the board goes to -z: its right side comes nearer.
    EXPECT_EQ(at({-100, -100, 400}, {0, 0.5236, 0}),
              "400 mm away, to the left of the image and high, its left side 30 deg farther away");
    EXPECT_EQ(at({0, 100, 400}, {0.5236, 0, 0}),
              "400 mm away, low in the image, its lower edge 30 deg farther away");
    EXPECT_EQ(in_words("channel0.camera.fx"), "focal length");
    EXPECT_EQ(in_words("channel0.mirror.g2"), "angle law of the mirror");
    EXPECT_EQ(in_words("something else"), "something else");
}

INSTANTIATE_TEST_SUITE_P(Machines, CoachOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

}  // namespace
}  // namespace stria

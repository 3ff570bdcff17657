#include "calib/certify.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>

#include "tests/calib/synthetic_scanner.h"

namespace stria {
namespace {

const ScannerCalibrationOptions kQuick{.stripe_points_per_view = 100};

/// Twelve views, of which every fourth checks; the calibration by the others.
struct Solved {
    explicit Solved(MachineKind kind, unsigned seed)
        : rng(seed), drawn(drawn_scanner(kind)), truth(built_scanner(drawn, rng)) {
        options.views = 12;
        options.pixel_step = 24;
        options.frames = 40;
        if (kind != MachineKind::swept) options.pictures = 3;
        const auto all = synthetic_views(truth, board, options, rng);
        for (std::size_t i = 0; i < all.size(); ++i)
            (i % 4 == 2 ? held_out : views).push_back(all[i]);
        found = calibrate_scanner(views, board, drawn, kQuick);
    }
    Certificate certificate() const {
        return certify(found, check_held_out(held_out, board, found),
                       cross_validate(views, board, found, 100));
    }

    std::mt19937 rng;
    Board board = parse_board("chessboard:12x9:22");
    ScannerModel drawn, truth;
    SyntheticOptions options;
    std::vector<CornerView> views, held_out;
    ScannerCalibration found;
};

class CertifyOf : public testing::TestWithParam<MachineKind> {};

TEST_P(CertifyOf, PassesGoodViewsAndStatesWhatIsTrue) {
    const Solved solved(GetParam(), 11);
    const HeldOutCheck check = check_held_out(solved.held_out, solved.board, solved.found);
    std::cout << name_of(GetParam()) << ": corners " << check.corner_rms << " sigma, stripes "
              << check.stripe_rms << " sigma, precision " << check.precision_mm << " mm, trueness "
              << check.trueness_mm << " of " << check.expected_trueness_mm << " mm, p "
              << check.p_value << std::endl;
    EXPECT_EQ(check.views, 3);
    EXPECT_NEAR(check.corner_rms, 1, 0.1);  // 600 and more residuals: 3 % one sigma
    EXPECT_NEAR(check.stripe_rms, 1, 0.15);
    EXPECT_GT(check.p_value, 1e-3);
    EXPECT_LT(check.trueness_mm, 3 * check.expected_trueness_mm);
    EXPECT_GT(check.precision_mm, 0.01);  // 0.1 px of stripe are about 0.08 mm of depth
    EXPECT_LT(check.precision_mm, 0.5);
    const Certificate certificate = solved.certificate();
    EXPECT_EQ(certificate.status, CertificateStatus::passed)
        << (certificate.reasons.empty() ? "" : certificate.reasons.front());
    EXPECT_EQ(certificate.check_views, 3);
    EXPECT_EQ(certificate.views, 9);
}

TEST(Certify, FailsAModelThatMovedSinceAndSaysWhy) {
    Solved solved(MachineKind::rail, 12);
    // The laser was knocked by a quarter of a degree after the calibration.
    Eigen::VectorXd knock =
        Eigen::VectorXd::Zero(static_cast<Eigen::Index>(parameter_names(solved.truth).size()));
    const auto names = parameter_names(solved.truth);
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == "channel0.sheet.tilt_b") knock[static_cast<Eigen::Index>(i)] = 0.004;
    SyntheticOptions few = solved.options;
    few.views = 3;
    solved.held_out =
        synthetic_views(perturbed(solved.truth, knock), solved.board, few, solved.rng);
    const Certificate certificate = solved.certificate();
    EXPECT_EQ(certificate.status, CertificateStatus::failed);
    ASSERT_FALSE(certificate.reasons.empty());
    EXPECT_LT(certificate.check_p_value, 1e-6);
}

TEST(Certify, WithoutHeldOutViewsNothingIsPassed) {
    Solved solved(MachineKind::rail, 13);
    solved.held_out.clear();
    const Certificate certificate = solved.certificate();
    EXPECT_EQ(certificate.status, CertificateStatus::unchecked);
    EXPECT_EQ(certificate.reasons.size(), 1U);
    solved.found.converged = false;
    EXPECT_EQ(solved.certificate().status, CertificateStatus::failed);
}

TEST(Certify, OnlyHalvesThatAreKnownWellEnoughCondemn) {
    ScannerCalibration solved;
    solved.converged = true;
    solved.model.volume = {Eigen::Vector3d::Zero(), Eigen::Vector3d(300, 200, 0)};  // limit 36 um
    HeldOutCheck check;
    check.views = 3;
    CrossValidation halves;
    halves.p_value = 1e-5;
    halves.tests = 5;
    SplitCheck split;
    split.how = "near and far";
    split.done = true;
    split.difference_mm = 0.1;
    split.expected_mm = 0.03;
    split.p_value = 2e-5;
    halves.splits = {split};
    const Certificate failed = certify(solved, check, halves);
    EXPECT_EQ(failed.status, CertificateStatus::failed);
    ASSERT_EQ(failed.reasons.size(), 1U);
    EXPECT_NE(failed.reasons[0].find("(p 2e-05)"), std::string::npos) << failed.reasons[0];
    halves.splits[0].p_value = 1e-3;  // one of five as unlikely: another test gave the alarm
    EXPECT_EQ(certify(solved, check, halves).status, CertificateStatus::passed);
    halves.splits[0].p_value = 2e-5;
    halves.splits[0].expected_mm = 0.06;  // few views in each half
    EXPECT_EQ(certify(solved, check, halves).status, CertificateStatus::passed);
}

TEST(Certify, FailsAnAxisThatRunsUnevenly) {
    Solved solved(MachineKind::turntable, 16);
    // A wave of 0.004 rad every 12 deg: a worn worm gear.
    const auto run_unevenly = [](std::vector<CornerView>& views) {
        for (CornerView& view : views)
            for (Pulse& pulse : view.pulses.pulses) pulse.s += 0.004F * std::sin(30 * pulse.s);
    };
    run_unevenly(solved.views);
    run_unevenly(solved.held_out);
    solved.found = calibrate_scanner(solved.views, solved.board, solved.drawn, kQuick);
    const Certificate certificate = solved.certificate();
    EXPECT_EQ(certificate.status, CertificateStatus::failed);
    EXPECT_TRUE(std::any_of(certificate.reasons.begin(), certificate.reasons.end(),
                            [](const std::string& reason) {
                                return reason.find("axis runs unevenly") != std::string::npos;
                            }));
}

TEST(Certify, SaysWhatMovedInSigmas) {
    const Solved solved(MachineKind::rail, 14);
    const auto samples = pulse_samples(solved.views, solved.found.model);
    const ScannerModel& model = solved.found.model;
    const Movement still = movement_of(model, model, samples);
    EXPECT_TRUE(still.comparable);
    EXPECT_EQ(still.rms_mm, 0);
    EXPECT_GT(still.expected_mm, 0);

    // Truth against the calibration: both uncertainties count though truth has none, so about 0.7.
    ScannerModel truth = solved.truth;
    truth.covariance = model.covariance;
    const Movement small = movement_of(truth, model, samples);
    EXPECT_LT(small.sigmas, 3);

    Eigen::VectorXd change = Eigen::VectorXd::Zero(model.covariance.rows());
    const auto names = parameter_names(model);
    Eigen::Index focal = 0;
    while (names[static_cast<std::size_t>(focal)] != "channel0.camera.fx") ++focal;
    change[focal] = 50 * std::sqrt(model.covariance(focal, focal));
    const Movement far = movement_of(model, perturbed(model, change), samples);
    EXPECT_GT(far.sigmas, 5);
    EXPECT_GT(far.most_sigmas, 5);
    EXPECT_FALSE(far.most.empty());

    ScannerModel bare = model;
    bare.covariance.resize(0, 0);
    EXPECT_FALSE(movement_of(bare, model, samples).comparable);
    EXPECT_FALSE(
        movement_of(Solved(MachineKind::turntable, 15).found.model, model, samples).comparable);
}

INSTANTIATE_TEST_SUITE_P(Machines, CertifyOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "calib/certify.h"
#include "tests/calib/synthetic_scanner.h"

/// Scanners calibrated with a board that bulges.
namespace stria {
namespace {

struct Trial {
    Trial(MachineKind kind, const Eigen::Vector2d& warp_mm, unsigned seed)
        : rng(seed), drawn(drawn_scanner(kind)), truth(built_scanner(drawn, rng)) {
        SyntheticOptions options;
        options.views = 15;
        options.pixel_step = 24;
        options.frames = 40;
        if (kind != MachineKind::swept) options.pictures = 3;
        auto all = synthetic_views(truth, with_warp(board, warp_mm), options, rng);
        for (std::size_t i = 0; i < all.size(); ++i)
            (i % 5 == 2 ? held_out : views).push_back(std::move(all[i]));
    }
    ScannerCalibration solve(bool board_warp) const {
        ScannerCalibrationOptions options = options_of_built_scanners();
        options.stripe_points_per_view = 100;
        options.board_warp = board_warp;
        return calibrate_scanner(views, board, drawn, options);
    }
    Certificate certificate(const ScannerCalibration& found) const {
        return certify(found, check_held_out(held_out, board, found),
                       cross_validate(views, board, found, 100));
    }

    std::mt19937 rng;
    Board board = parse_board("chessboard:12x9:22");
    ScannerModel drawn, truth;
    std::vector<CornerView> views, held_out;
};

class BoardWarpOf : public testing::TestWithParam<MachineKind> {};

TEST_P(BoardWarpOf, IsFoundWithItsSigmaAndHarmsNothing) {
    constexpr int kTrials = STRIA_WARP_TRIALS;
    const Eigen::Vector2d warp(0.5, -0.3);
    double chi_square = 0, squares = 0, predicted = 0, flat_squares = 0;
    for (unsigned seed = 0; seed < kTrials; ++seed) {
        const Trial trial(GetParam(), warp, 300 + seed);
        const ScannerCalibration found = trial.solve(true);
        const auto voxels = volume_voxels(trial.truth, trial.views);
        const Eigen::Vector2d off = found.board_warp_mm - warp;
        chi_square += off.cwiseQuotient(found.board_warp_sigma_mm).squaredNorm();
        squares += std::pow(point_error(trial.truth, found.model, voxels).rms_mm, 2);
        predicted += std::pow(predict_sigma(found.model, voxels).rms_mm, 2);
        const Certificate certificate = trial.certificate(found);
        EXPECT_EQ(certificate.status, CertificateStatus::passed)
            << seed << ' ' << (certificate.reasons.empty() ? "" : certificate.reasons.front());
        const ScannerCalibration flat = trial.solve(false);
        flat_squares += std::pow(point_error(trial.truth, flat.model, voxels).rms_mm, 2);
        EXPECT_EQ(flat.board_warp_mm, Eigen::Vector2d::Zero());
        if (seed > 0) continue;
        const Certificate of_flat = trial.certificate(flat);
        std::cout << name_of(GetParam()) << ": warp " << found.board_warp_mm.transpose() << " +- "
                  << found.board_warp_sigma_mm.transpose()
                  << " mm; taken as flat: " << name_of(of_flat.status) << ", corners "
                  << flat.rms_px << " for " << found.rms_px << " px rms" << std::endl;
    }
    std::cout << "chi-square " << chi_square / (2 * kTrials)
              << " a degree of freedom; points off by " << std::sqrt(squares / predicted)
              << " of the predicted, taken as flat by " << std::sqrt(flat_squares / squares)
              << " times as much" << std::endl;
    EXPECT_NEAR(chi_square / (2 * kTrials), 1, 3 * std::sqrt(2.0 / (2 * kTrials)));
    EXPECT_NEAR(std::sqrt(squares / predicted), 1, 3 / std::sqrt(8.0 * kTrials));
    EXPECT_GT(flat_squares, 2 * squares);
}

TEST_P(BoardWarpOf, OfAFlatBoardIsNone) {
    const Trial trial(GetParam(), Eigen::Vector2d::Zero(), 310);
    const ScannerCalibration found = trial.solve(true);
    EXPECT_LT(found.board_warp_sigma_mm.maxCoeff(), 0.1);
    EXPECT_LT(found.board_warp_mm.cwiseQuotient(found.board_warp_sigma_mm).norm(), 3.5);
    EXPECT_EQ(trial.certificate(found).status, CertificateStatus::passed);
}

TEST_P(BoardWarpOf, ThatIsKnownIsTakenAsItIs) {
    const Eigen::Vector2d warp(-0.4, 0.6);
    Trial trial(GetParam(), warp, 320);
    trial.board.warp_mm = warp;
    const ScannerCalibration found = trial.solve(false);
    EXPECT_EQ(found.board_warp_mm, warp);
    EXPECT_EQ(found.board_warp_sigma_mm, Eigen::Vector2d::Zero());
    EXPECT_EQ(trial.certificate(found).status, CertificateStatus::passed);
}

INSTANTIATE_TEST_SUITE_P(Machines, BoardWarpOf,
                         testing::Values(MachineKind::swept, MachineKind::rail,
                                         MachineKind::turntable),
                         [](const auto& machine) { return std::string(name_of(machine.param)); });

}  // namespace
}  // namespace stria

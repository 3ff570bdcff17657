#include "host/verify/noise_range.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "host/verify/residuals.h"

namespace stria {
namespace {

TEST(NoiseRange, IsTheTabulatedRangeOfNormalSamples) {
    // d2 of control charts (ASTM E2587, table 6), the expected range of n values.
    EXPECT_NEAR(expected_range(2, 0), 2 / std::sqrt(M_PI), 1e-4);
    EXPECT_NEAR(expected_range(10, 0), 3.078, 1e-3);
    EXPECT_NEAR(expected_range(25, 0), 3.931, 1e-3);
    EXPECT_NEAR(expected_range(1000, 0), 6.483, 2e-3);  // Tippett 1925
}

TEST(NoiseRange, FallsByRejectingThreeInAThousand) {
    // Known from simulation, two digits: 5.7, 5.9, 5.9 standard deviations.
    EXPECT_NEAR(expected_range(1000, 3), 5.7, 0.06);
    EXPECT_NEAR(expected_range(10000, 30), 5.9, 0.06);
    EXPECT_NEAR(expected_range(100000, 300), 5.9, 0.06);
    EXPECT_NEAR(expected_range(10000, 0), 7.7, 0.05);
    EXPECT_NEAR(expected_range(100000, 0), 8.8, 0.05);
}

TEST(NoiseRange, IsWhatSimulatedResidualsOfTwoSigmasShow) {
    constexpr std::size_t kCount = 2000;
    constexpr int kTrials = 400;
    std::vector<double> sigmas(kCount, 1.0);
    for (std::size_t i = 0; i < kCount / 4; ++i) sigmas[i] = 2.0;
    std::mt19937 rng(11);
    std::normal_distribution<double> gauss;
    for (const std::size_t rejected : {std::size_t{0}, most_rejected(kCount)}) {
        double sum = 0, squares = 0;
        for (int trial = 0; trial < kTrials; ++trial) {
            std::vector<double> values;
            for (const double sigma : sigmas) values.push_back(sigma * gauss(rng));
            const std::vector<std::uint8_t> kept = keep_mask(values, rejected);
            double low = 0, high = 0;
            for (std::size_t i = 0; i < kCount; ++i)
                if (kept[i] != 0) {
                    low = std::min(low, values[i]);
                    high = std::max(high, values[i]);
                }
            sum += high - low;
            squares += (high - low) * (high - low);
        }
        const double mean = sum / kTrials;
        const double error = std::sqrt((squares / kTrials - mean * mean) / kTrials);
        // Four standard errors of the mean, and 0.5 % for the Poisson step.
        EXPECT_NEAR(expected_range(sigmas, rejected), mean, 4 * error + 0.005 * mean) << rejected;
    }
}

TEST(NoiseRange, IsNothingWhereNothingIsLeft) {
    EXPECT_EQ(expected_range(0, 0), 0);
    EXPECT_EQ(expected_range(1, 0), 0);
    EXPECT_EQ(expected_range(4, 3), 0);
    EXPECT_EQ(expected_range(std::vector<double>(5, 0.0), 0), 0);
}

TEST(Residuals, RejectsTheFarthestAndNoMoreThanAllowed) {
    EXPECT_EQ(most_rejected(333), 0U);
    EXPECT_EQ(most_rejected(334), 1U);
    EXPECT_EQ(most_rejected(10000), 30U);
    const std::vector<std::uint8_t> kept = keep_mask({0.1, -0.5, 0.2, 0.5, 0.0}, 2);
    EXPECT_EQ(kept, (std::vector<std::uint8_t>{1, 0, 1, 0, 1}));
}

TEST(Residuals, D95IsTheNarrowestShellOf95Percent) {
    std::vector<double> residuals;  // 95 evenly over 0.94, 5 far away on one side
    for (int i = 0; i < 95; ++i) residuals.push_back(0.01 * i);
    for (int i = 0; i < 5; ++i) residuals.push_back(3.0 + i);
    ScanPoints points;
    points.positions.resize(residuals.size());
    const std::vector<Eigen::Vector3d> normals(residuals.size(), Eigen::Vector3d::UnitZ());
    const FormFigures figures =
        form_figures(residuals, keep_mask(residuals, 0), 0, points, normals);
    EXPECT_NEAR(figures.d95_mm, 0.94, 1e-12);
    EXPECT_NEAR(figures.form_mm, 7.0, 1e-12);
    EXPECT_TRUE(std::isnan(figures.predicted_sigma_mm));  // the scan states no sigma
    EXPECT_TRUE(std::isnan(figures.sigma_ratio));
}

}  // namespace
}  // namespace stria

#include "host/advise/gaussian_beam.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "host/core/laser_sheet.h"

namespace stria {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

TEST(GaussianBeam, WaistAtTheMirrorOfAccuracyFinding5) {
    // Published: 100 um waist at the mirror, 650 nm, D = 500 mm.
    const GaussianBeam beam{.waist_sigma_mm = 0.1, .wavelength_nm = 650, .m_squared = 1};
    EXPECT_NEAR(sigma_at_mm(beam, 500), 0.277, 0.0005);
    EXPECT_NEAR(wavefront_radius_mm(beam, 500), 574, 1);  // mm; 574.7, printed without rounding
    EXPECT_NEAR(effective_distance_mm(500, wavefront_radius_mm(beam, 500)), 3800, 50);
}

TEST(GaussianBeam, IsTheOneOfTheScannerModel) {
    LaserSheet sheet;
    sheet.waist_sigma_mm = 0.13;
    sheet.waist_at_mm = 200;
    sheet.wavelength_nm = 520;
    const GaussianBeam beam{0.13, 520, 1};
    for (double z = -200; z < 900; z += 50)
        EXPECT_NEAR(sigma_at_mm(beam, z), sigma_at(sheet, Eigen::Vector3d(0, 0, 200 + z)), 1e-12);
}

TEST(GaussianBeam, MSquaredActsAsALongerWavelength) {
    const GaussianBeam poor{0.1, 500, 1.5}, longer{0.1, 750, 1};
    EXPECT_NEAR(sigma_at_mm(poor, 321), sigma_at_mm(longer, 321), 1e-12);
    EXPECT_NEAR(rayleigh_mm(poor), rayleigh_mm(longer), 1e-9);
}

TEST(GaussianBeam, WavefrontCurvesMostAtTheRayleighLength) {
    const GaussianBeam beam{0.1, 650, 1.2};
    const double z_r = rayleigh_mm(beam);
    EXPECT_NEAR(wavefront_radius_mm(beam, z_r), 2 * z_r, 1e-9);
    EXPECT_NEAR(sigma_at_mm(beam, z_r), 0.1 * std::sqrt(2), 1e-12);
    EXPECT_NEAR(depth_of_field_mm(beam), 2 * z_r, 1e-12);
    EXPECT_EQ(wavefront_radius_mm(beam, 0), kInfinite);
    EXPECT_LT(wavefront_radius_mm(beam, -50), 0);
}

TEST(GaussianBeam, WaistForAWidthGivesThatWidth) {
    std::mt19937 rng(5);
    std::uniform_real_distribution<double> u(0, 1);
    int reached = 0;
    for (int i = 0; i < 300; ++i) {
        const double sigma = 0.05 + u(rng), z = 20 + 800 * u(rng), nm = 400 + 400 * u(rng),
                     m2 = 1 + u(rng);
        const double waist = waist_for_mm(sigma, z, nm, m2);
        const double got = sigma_at_mm({waist, nm, m2}, z);
        const double least = std::sqrt(2 * m2 * nm * 1e-6 * z / (4 * M_PI));
        EXPECT_NEAR(got, std::max(sigma, least), 1e-9) << sigma << " " << z << " " << nm;
        EXPECT_LE(waist, got / std::sqrt(2) + 1e-9) << "the narrow one of the two";
        reached += sigma > least;
    }
    EXPECT_GT(reached, 100);
    EXPECT_NEAR(waist_for_mm(0.3, 0, 650, 1), 0.3, 1e-12);
}

TEST(GaussianBeam, SpeckleIsFrozenWhereTheWavefrontTurnsAboutItsCentre) {
    EXPECT_EQ(effective_distance_mm(400, 400), kInfinite);
    EXPECT_EQ(effective_distance_mm(kInfinite, kInfinite), kInfinite);
    EXPECT_NEAR(effective_distance_mm(400, kInfinite), 400, 1e-12);
    EXPECT_NEAR(effective_distance_mm(kInfinite, -250), 250, 1e-12);
}

}  // namespace
}  // namespace stria

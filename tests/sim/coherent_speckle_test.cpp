#include "sim/coherent_speckle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/sim/speckle_trials.h"

// Closed forms of Goodman, Speckle Phenomena in Optics, 2007, and of optics/statistics named at
// each test. Tolerances of 5 % and 10 % are the simulator's acceptance limits; the numbers of
// speckles are chosen so that chance stays at a third of them.
namespace stria {
namespace {

constexpr double kRhoMm = 650e-6 / (2 * 0.005);

CoherentView view_of(double pixel_rhos, int columns, int rows) {
    return {.wavelength_nm = 650,
            .sin_u = 0.005,
            .pixel_mm = pixel_rhos * kRhoMm,
            .columns = columns,
            .rows = rows};
}

double airy(double rhos) {  // |2 J1(v) / v|^2, v = pi r / rho
    if (rhos == 0) return 1;
    const double v = std::numbers::pi * rhos;
    return std::pow(2 * std::cyl_bessel_j(1.0, v) / v, 2);
}

struct Moments {
    double mean = 0, contrast = 0, third = 0;  ///< third: E (I / mean - 1)^3
};
Moments moments_of(const std::vector<double>& light) {
    Moments m;
    const auto n = static_cast<double>(light.size());
    for (double i : light) m.mean += i / n;
    double square = 0;
    for (double i : light) {
        square += std::pow(i / m.mean - 1, 2) / n;
        m.third += std::pow(i / m.mean - 1, 3) / n;
    }
    m.contrast = std::sqrt(square);
    return m;
}

TEST(CoherentSpeckle, HasNegativeExponentialLightBeforeThePixel) {
    const CoherentSurface surface(view_of(1, 128, 128), 1);  // 16 000 speckles
    const std::vector<double> light = surface.evenly_lit();
    const Moments m = moments_of(light);
    EXPECT_NEAR(m.mean, 1, 0.02);
    EXPECT_NEAR(m.contrast, 1, 0.05);
    EXPECT_NEAR(m.third, 2, 0.2);
    for (const double at : {0.1, 0.5, 1.0, 2.0, 3.0}) {
        const auto above =
            std::count_if(light.begin(), light.end(), [&](double i) { return i > at * m.mean; });
        EXPECT_NEAR(static_cast<double>(above) / static_cast<double>(light.size()), std::exp(-at),
                    0.05 * std::exp(-at))
            << at;
    }
}

TEST(CoherentSpeckle, OfACrossSectionHasTheKernelsCovarianceAndSeparateRows) {
    CoherentView view = view_of(1, 128, 256);
    view.cross_section = true;
    const CoherentSurface surface(view, 4);
    const std::vector<double> light = surface.evenly_lit();
    const Moments m = moments_of(light);
    EXPECT_NEAR(m.mean, 1, 0.02);
    EXPECT_NEAR(m.contrast, 1, 0.05);
    const int width = surface.cell_columns(), height = surface.cell_rows();
    const auto covariance = [&](int dx, int dy) {
        double sum = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                sum +=
                    (light[static_cast<std::size_t>(y * width + x)] - m.mean) *
                    (light[static_cast<std::size_t>((y + dy) % height * width + (x + dx) % width)] -
                     m.mean);
        return sum / (width * height * m.mean * m.mean);
    };
    // The kernel 2 J1(v) / v with itself: 3 (sin v - v cos v) / v^3, its square for the light.
    for (int dx = 1; dx <= 8; ++dx) {
        const double v = std::numbers::pi * dx * surface.cell_mm() / surface.rho_mm();
        const double field = 3 * (std::sin(v) - v * std::cos(v)) / (v * v * v);
        EXPECT_NEAR(covariance(dx, 0), field * field, 0.05) << dx;
    }
    EXPECT_NEAR(covariance(0, 1), 0, 0.02);  // 3 standard deviations
}

TEST(CoherentSpeckle, HasTheCovarianceOfACircularAperture) {
    const CoherentSurface surface(view_of(1, 128, 128), 2);
    const std::vector<double> light = surface.evenly_lit();
    const double mean = moments_of(light).mean;
    const auto covariance = [&](int dx, int dy) {
        double sum = 0;
        const int w = surface.cell_columns(), h = surface.cell_rows();
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x)
                sum +=
                    (light[static_cast<std::size_t>(y * w + x)] / mean - 1) *
                    (light[static_cast<std::size_t>((y + dy) % h * w + (x + dx) % w)] / mean - 1);
        return sum / (w * h);
    };
    for (int lag = 0; lag <= 12; ++lag) {
        const double rhos = lag * surface.cell_mm() / kRhoMm;
        EXPECT_NEAR(covariance(lag, 0), airy(rhos), 0.05) << rhos;
        EXPECT_NEAR(covariance(0, lag), airy(rhos), 0.05) << rhos;
        EXPECT_NEAR(covariance(lag, lag), airy(rhos * std::numbers::sqrt2), 0.05) << rhos;
    }
}

/// Cumulants 2 and 3 of the light of a pixel of mean 1: of W = sum of eigenvalues of the field's
/// covariance over the pixel, each times a negative exponential number, they are tr K^2 and
/// 2 tr K^3 (Goodman, sec. 4.7).
struct Cumulants {
    double second = 0, third = 0;
};
Cumulants pixel_cumulants(double side_rhos) {
    constexpr int kSide = 12, kNodes = kSide * kSide;
    std::vector<double> k(kNodes * kNodes);
    for (int i = 0; i < kNodes; ++i)
        for (int j = 0; j < kNodes; ++j) {
            const double v = std::numbers::pi * side_rhos / kSide *
                             std::hypot(i % kSide - j % kSide, i / kSide - j / kSide);
            k[static_cast<std::size_t>(i * kNodes + j)] =
                (v == 0 ? 1 : 2 * std::cyl_bessel_j(1.0, v) / v) / kNodes;
        }
    Cumulants result;
    for (std::size_t i = 0; i < kNodes; ++i)
        for (std::size_t j = 0; j < kNodes; ++j) {
            double product = 0;
            for (std::size_t l = 0; l < kNodes; ++l)
                product += k[i * kNodes + l] * k[l * kNodes + j];
            result.second += k[i * kNodes + j] * k[j * kNodes + i];
            result.third += 2 * product * k[j * kNodes + i];
        }
    return result;
}

TEST(CoherentSpeckle, HasGammaLightAfterThePixel) {
    for (const double side : {1.5, 3.0}) {
        const CoherentSurface surface(view_of(side, 128, 128), 3);
        const std::vector<double> light = surface.pixels_of(surface.evenly_lit());
        const Moments m = moments_of(light);
        const Cumulants expected = pixel_cumulants(side);
        const double c2 = expected.second, contrast = std::sqrt(c2);
        EXPECT_NEAR(m.contrast, contrast, 0.05 * contrast) << side;
        EXPECT_NEAR(m.third, expected.third, 0.15 * expected.third) << side;  // chance: 5 %
        // Goodman's gamma of shape 1 / C^2 is near that: the share of pixels below half the mean.
        const double shape = 1 / c2;
        double dark = 0;
        for (int i = 0; i < 1000; ++i) {
            const double x = 0.5 * (i + 0.5) / 1000;
            dark += 0.5 / 1000 *
                    std::exp(shape * std::log(shape) + (shape - 1) * std::log(x) - shape * x -
                             std::lgamma(shape));
        }
        const auto found =
            std::count_if(light.begin(), light.end(), [&](double i) { return i < 0.5 * m.mean; });
        EXPECT_NEAR(static_cast<double>(found) / static_cast<double>(light.size()), dark, 0.02);
    }
}

// The light of a wide line that turns by an angle a at a point decorrelates as the aperture's
// transfer function at a / (2 sin u): the disc's overlap with itself, shifted by a / lambda. With a
// line whose wavefront is centred on the turning point nothing changes.
TEST(CoherentSpeckle, BoilsAsTheLightTurns) {
    const double sigma_mm = 16 * kRhoMm, distance_mm = 150;
    const CoherentSurface surface(view_of(1, 512, 64), 4);
    const double centre_mm = surface.width_mm() / 2;
    const auto column = static_cast<std::size_t>(surface.cell_columns() / 2);
    for (const double fraction : {0.1, 0.3, 0.5}) {
        const double way_mm =
            fraction * 2 * 0.005 * distance_mm;  // of the line, seen at its middle
        const auto correlation = [&](const CoherentLine& line) {
            const auto before = surface.lit_by(line, centre_mm - way_mm / 2);
            const auto after = surface.lit_by(line, centre_mm + way_mm / 2);
            double a = 0, b = 0, aa = 0, bb = 0, ab = 0;
            int n = 0;
            for (int y = 0; y < surface.cell_rows(); ++y)
                for (int dx = -16; dx < 16; ++dx, ++n) {  // 8 rho, a quarter of the line's sigma
                    const std::size_t at = static_cast<std::size_t>(y * surface.cell_columns()) +
                                           column + static_cast<std::size_t>(dx + 16) - 16;
                    a += before[at], b += after[at];
                    aa += before[at] * before[at], bb += after[at] * after[at];
                    ab += before[at] * after[at];
                }
            return (ab - a * b / n) / std::sqrt((aa - a * a / n) * (bb - b * b / n));
        };
        const double transfer =
            2 / std::numbers::pi *
            (std::acos(fraction) - fraction * std::sqrt(1 - fraction * fraction));
        EXPECT_NEAR(correlation({.sigma_mm = sigma_mm, .turning_mm = distance_mm}),
                    transfer * transfer, 0.12)  // 500 speckles: 0.04 by chance
            << fraction;
        EXPECT_GT(
            correlation(
                {.sigma_mm = sigma_mm, .turning_mm = distance_mm, .wavefront_mm = distance_mm}),
            0.97)  // only the line's own shape has moved
            << fraction;
    }
}

TEST(CoherentSpeckle, MovesARowsMomentAsTheoryHasIt) {
    SpeckleTrials trials{
        .view = view_of(1.5, 64, 16), .line = {.sigma_mm = 4 * kRhoMm}, .surfaces = 3, .seed = 5};
    const SpeckleResult result = run(trials);
    const RowSpeckle row = row_speckle(kRhoMm, trials.view.pixel_mm);
    const double expected_mm = std::sqrt(1 / (4 * std::sqrt(std::numbers::pi))) * row.contrast *
                               std::sqrt(row.length_mm * trials.line.sigma_mm);
    EXPECT_NEAR(result.spatial.weighted_mm, expected_mm, 0.1 * expected_mm);
    EXPECT_LT(result.spacetime.weighted_mm, 0.75 * result.spatial.weighted_mm);
    EXPECT_GT(result.claimed, 0.99);
}

TEST(CoherentSpeckle, MovesAPointsPulseAsTheoryHasIt) {
    SpeckleTrials trials{
        .view = view_of(0.25, 64, 32), .line = {.sigma_mm = 2 * kRhoMm}, .surfaces = 1, .seed = 6};
    const SpeckleResult result = run(trials);
    const double expected_mm = kRhoMm * point_moment_by_square(2);
    EXPECT_NEAR(result.moments_by_square_mm, expected_mm, 0.1 * expected_mm);
}

TEST(CoherentSpeckle, RefusesWhatCannotBe) {
    CoherentView view = view_of(1, 64, 8);
    view.columns = 60;
    EXPECT_THROW(CoherentSurface(view, 1), std::invalid_argument);
    view = view_of(1, 64, 8);
    view.sin_u = 0;
    EXPECT_THROW(CoherentSurface(view, 1), std::invalid_argument);
    view = view_of(1, 64, 8);
    view.soft_edge = 1.5;
    EXPECT_THROW(CoherentSurface(view, 1), std::invalid_argument);
    const CoherentSurface surface(view_of(1, 64, 8), 1);
    EXPECT_THROW(surface.lit_by({.sigma_mm = surface.width_mm()}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace stria

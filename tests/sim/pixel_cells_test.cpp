#include "sim/pixel_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace stria {
namespace {

/// A pixel lit where `is_lit`, the sheet's place `position(u, v)` in beam widths.
template <typename Lit, typename Position>
std::vector<PixelPart> cut(const Lit& is_lit, const Position& position, int cells = 4,
                           int* rays = nullptr) {
    std::vector<PixelPart> parts;
    cut_pixel(
        [&](std::span<const Eigen::Vector2d> places, std::span<PixelSample> samples) {
            for (std::size_t i = 0; i < places.size(); ++i) {
                RayLight& light = samples[i].light;
                light = {};
                light.judged = true;
                light.object = 0;
                light.position = position(places[i]);
                light.per_position = light.per_s = 1;
                light.rate = is_lit(places[i]) ? 1000.0F : 0.0F;
            }
            if (rays) *rays += static_cast<int>(places.size());
        },
        {.cells = cells}, parts);
    return parts;
}

double lit_share(const std::vector<PixelPart>& parts) {
    double all = 0, lit = 0;
    for (const PixelPart& part : parts) {
        all += part.share;
        lit += part.share * static_cast<double>(part.sample.light.rate) / 1000;
    }
    EXPECT_NEAR(all, 1, 1e-6);  // single precision of rates and means
    return lit;
}

double flat(const Eigen::Vector2d&) { return 0; }

/// Share of the unit pixel where direction . place < offset, by 2000 columns cut exactly.
double half_plane_share(const Eigen::Vector2d& direction, double offset) {
    constexpr int kColumns = 2000;
    double sum = 0;
    for (int i = 0; i < kColumns; ++i) {
        const double u = (i + 0.5) / kColumns - 0.5;
        const double edge = (offset - direction.x() * u) / direction.y();
        sum += std::clamp(direction.y() > 0 ? edge + 0.5 : 0.5 - edge, 0.0, 1.0) / kColumns;
    }
    return sum;
}

TEST(PixelCells, AStraightBorderPartsThePixelByItsArea) {
    std::mt19937 rng(11);
    std::uniform_real_distribution<double> angle(0.01, 3.13), offset(-0.6, 0.6);
    double worst = 0, worst_of_16_rays = 0;
    for (int trial = 0; trial < 400; ++trial) {
        const double a = angle(rng), d = offset(rng);
        const Eigen::Vector2d direction(std::cos(a), std::sin(a));
        const auto is_lit = [&](const Eigen::Vector2d& p) { return direction.dot(p) < d; };
        const double share = half_plane_share(direction, d);
        worst = std::max(worst, std::abs(lit_share(cut(is_lit, flat)) - share));
        double counted = 0;
        for (int i = 0; i < 16; ++i) {
            const int column = i % 4, row = i / 4;
            counted += is_lit({(column + (row + 0.5) / 4) / 4 - 0.5,
                               (row + (column + 0.5) / 4) / 4 - 0.5}) /
                       16.0;
        }
        worst_of_16_rays = std::max(worst_of_16_rays, std::abs(counted - share));
    }
    std::printf("worst share off by %.1e, of 16 rays by %.1e\n", worst, worst_of_16_rays);
    EXPECT_LT(worst, 1e-3);             // of the pixel: sides are halved to 1/1024
    EXPECT_GT(worst_of_16_rays, 0.03);  // what counting alone does
}

TEST(PixelCells, ARoundBorderToo) {
    for (double radius : {0.4, 1.0, 5.0}) {
        const Eigen::Vector2d centre(0.1 - radius, 0.03);
        constexpr int kSteps = 2000;
        double share = 0;
        const auto is_lit = [&](const Eigen::Vector2d& p) { return (p - centre).norm() < radius; };
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j)
                share += is_lit({(i + 0.5) / kSteps - 0.5, (j + 0.5) / kSteps - 0.5});
        share /= kSteps * double{kSteps};
        // A chord c cuts off c^3 / (12 radius): at most a cell's diagonal each, 1.3 px of them.
        EXPECT_NEAR(lit_share(cut(is_lit, flat)), share, 1e-3 + 1.3 / (8 * 12 * radius)) << radius;
    }
}

TEST(PixelCells, PlacesKeepTheirMeanAndVarianceOnSlopesBowlsAndFolds) {
    const auto everywhere = [](const Eigen::Vector2d&) { return true; };
    const auto moments = [&](const auto& position) {
        double mean = 0, square = 0;
        for (const PixelPart& part : cut(everywhere, position)) {
            const double at = part.sample.light.position;
            mean += part.share * at;
            square += part.share * (at * at + part.footprint2);
        }
        return std::pair{mean, square - mean * mean};
    };
    // A slope of a, b: mean 0, variance (a^2 + b^2) / 12, to the last bit of single precision.
    const auto [flat_mean, slope] =
        moments([](const Eigen::Vector2d& p) { return 0.8 * p.x() - 0.3 * p.y(); });
    EXPECT_NEAR(flat_mean, 0, 1e-9);
    EXPECT_NEAR(slope, (0.64 + 0.09) / 12, 1e-9);
    // A bowl k (u^2 + v^2) / 2 has the mean k / 12.
    EXPECT_NEAR(moments([](const Eigen::Vector2d& p) { return 0.6 * p.squaredNorm() / 2; }).first,
                0.6 / 12, 1e-9);
    // A fold |u - c|: mean 1/4 + c^2.
    for (double c : {0.0, 0.07, 0.13, -0.31})
        EXPECT_NEAR(moments([&](const Eigen::Vector2d& p) { return std::abs(p.x() - c); }).first,
                    0.25 + c * c, 1.5e-3)  // beam widths: Simpson's rule on eighths of a pixel
            << c;
}

// A slope seen up to a border: mean and variance of place are those of the lit part.
TEST(PixelCells, PlacesBesideABorderKeepTheirMeanAndVariance) {
    std::mt19937 rng(5);
    std::uniform_real_distribution<double> any(-1, 1);
    for (int trial = 0; trial < 40; ++trial) {
        const double a = any(rng) * 3, d = 0.3 * any(rng), su = any(rng), sv = any(rng);
        const Eigen::Vector2d direction(std::cos(a), std::sin(a));
        const auto is_lit = [&](const Eigen::Vector2d& p) { return direction.dot(p) < d; };
        const auto position = [&](const Eigen::Vector2d& p) { return su * p.x() + sv * p.y(); };
        double share = 0, mean = 0, square = 0;
        constexpr int kSteps = 400;
        for (int i = 0; i < kSteps; ++i)
            for (int j = 0; j < kSteps; ++j) {
                const Eigen::Vector2d p((i + 0.5) / kSteps - 0.5, (j + 0.5) / kSteps - 0.5);
                if (!is_lit(p)) continue;
                share += 1;
                mean += position(p);
                square += position(p) * position(p);
            }
        double s = 0, m = 0, q = 0;
        for (const PixelPart& part : cut(is_lit, position)) {
            if (part.sample.light.rate <= 0) continue;
            const double at = part.sample.light.position;
            s += part.share;
            m += part.share * at;
            q += part.share * (at * at + part.footprint2);
        }
        // 400 x 400 points know the lit part's border to 1e-3 px.
        EXPECT_NEAR(m / s, mean / share, 2e-3) << trial;
        EXPECT_NEAR(q / s - m / s * m / s, square / share - mean / share * mean / share, 2e-3)
            << trial;
    }
}

TEST(PixelCells, RaysGoWhereTheBorderIs) {
    int even = 0, crossed = 0;
    (void)cut([](const Eigen::Vector2d&) { return true; }, flat, 4, &even);
    (void)cut([](const Eigen::Vector2d& p) { return p.x() < 0.1; }, flat, 4, &crossed);
    EXPECT_EQ(even, 25 + 16);
    // Five sides in five rounds of three; for each of four cells two centroids, two checks of the
    // border's straightness, two slopes of each part.
    EXPECT_EQ(crossed, 25 + 12 + 5 * 5 * 3 + 4 * 8);
}

}  // namespace
}  // namespace stria

#include "host/scan/centre_of_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

/// Pulses as closed forms give them: what a Gaussian footprint sees of a step of reflectance, and
/// the first moment of its light.
namespace stria {
namespace {

constexpr double kPitch = 2e-3;  // s per px
constexpr double kSpeed = 1;     // s per second
constexpr double kBeamPx = 4;    // standard deviation of the pulse, px of the stripe's way

double phi(double z) { return std::exp(-z * z / 2) / std::sqrt(2 * std::numbers::pi); }
double cumulative(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

/// Light and its centre.
struct Seen {
    double light = 1, shift_px = 0;
};

/// A footprint at `from_edge` px beyond a step from 1 to `contrast`: the moments of a Gaussian's
/// two halves.
Seen seen_at_step(double from_edge, double contrast, double footprint_px) {
    const double z = from_edge / footprint_px;
    const double light = 1 + (contrast - 1) * cumulative(z);
    return {light, footprint_px * (contrast - 1) * phi(z) / light};
}

class Map {
  public:
    Map(int columns, int rows) : width(columns), height(rows) {
        pulses_.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    }
    /// A plane that the stripe crosses along u; `noise` is the standard deviation of s over that of
    /// the pulse, and that of the amplitude over the amplitude.
    void fill(const std::function<Seen(int x, int y)>& seen, double noise, unsigned seed) {
        std::mt19937_64 rng(seed);
        std::normal_distribution<double> normal;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const Seen at = seen(x, y);
                Pulse& pulse = (*this)(x, y);
                pulse.u = static_cast<float>(x);
                pulse.v = static_cast<float>(y);
                pulse.ds_dt = kSpeed;
                pulse.s = kPitch * (x + at.shift_px + kBeamPx * noise * normal(rng));
                pulse.width = static_cast<float>(kBeamPx * kPitch / kSpeed * 1e9);
                pulse.sigma = pulse.width * static_cast<float>(noise);
                pulse.amplitude =
                    static_cast<float>(100 * at.light * std::exp(noise * normal(rng)));
            }
    }
    Pulse& operator()(int x, int y) {
        return pulses_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(x)];
    }
    std::vector<const Pulse*> chosen() const {
        std::vector<const Pulse*> all;
        for (const Pulse& pulse : pulses_) all.push_back(pulse.amplitude > 0 ? &pulse : nullptr);
        return all;
    }
    std::vector<CentreOfLight> centres(double footprint_px) const {
        return centres_of_light(chosen(), width, height, footprint_px);
    }
    std::size_t cell(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }

    int width, height;

  private:
    std::vector<Pulse> pulses_;
};

/// Slanted stripes of reflectance, six px wide, so that edges stand at every phase.
Seen slanted_stripes(int x, int y, double contrast, double footprint_px) {
    const double along = x + 0.13 * y, from_edge = std::remainder(along, 12.0);
    // Edges at -3 (rising) and 3 (falling) of each period; the others are far enough away.
    return from_edge < 0 ? seen_at_step(from_edge + 3, contrast, footprint_px) : [&] {
        Seen mirrored = seen_at_step(3 - from_edge, contrast, footprint_px);
        mirrored.shift_px = -mirrored.shift_px;
        return mirrored;
    }();
}

TEST(CentreOfLight, IsWhereAStepOfReflectancePutsIt) {
    // What is left is the step between pixels: the narrower the footprint, the more. Bounds a
    // tenth above what the closed form gives with these differences.
    const struct {
        double footprint_px, left;
    } cases[] = {{0.42, 0.44}, {0.58, 0.27}, {0.8, 0.14}, {1.1, 0.10}};
    for (const auto& [footprint, left] : cases)
        for (const double contrast : {2.0, 5.0, 10.0}) {
            Map map(120, 90);
            map.fill([contrast, px = footprint](
                         int x, int y) { return slanted_stripes(x, y, contrast, px); },
                     0, 1);
            const auto centres = map.centres(footprint);
            double worst_before = 0, worst_after = 0;
            for (int y = 0; y < map.height; ++y)
                for (int x = 2; x < map.width - 2; ++x) {
                    const double shift = slanted_stripes(x, y, contrast, footprint).shift_px;
                    const double found = static_cast<double>(centres[map.cell(x, y)].shift_px.x());
                    worst_before = std::max(worst_before, std::abs(shift));
                    worst_after = std::max(worst_after, std::abs(shift - found));
                }
            std::printf("footprint %.2f px, %2.0f:1: %.3f px, %.3f left\n", footprint, contrast,
                        worst_before, worst_after);
            EXPECT_GT(worst_before, 0.2 * footprint);
            EXPECT_LT(worst_after, left * worst_before);
        }
}

TEST(CentreOfLight, StatesItsScatter) {
    constexpr double kFootprint = 0.58, kNoise = 0.03;
    Map map(200, 200);
    map.fill([](int, int) { return Seen{}; }, kNoise, 5);
    const auto centres = map.centres(kFootprint);
    double squares = 0;
    int count = 0;
    for (int y = 2; y < map.height - 2; ++y)
        for (int x = 2; x < map.width - 2; ++x)
            for (int axis = 0; axis < 2; ++axis, ++count) {
                const CentreOfLight& centre = centres[map.cell(x, y)];
                squares +=
                    std::pow(static_cast<double>(centre.shift_px[axis] / centre.sigma_px[axis]), 2);
            }
    EXPECT_NEAR(std::sqrt(squares / count), 1, 0.02);  // 77 000 numbers, neighbours correlated
}

TEST(CentreOfLight, DoesNotCompareSurfacesWithEachOther) {
    Map map(40, 10);
    map.fill([](int x, int) { return Seen{x < 20 ? 1.0 : 10.0, 0}; }, 0, 1);
    for (int y = 0; y < map.height; ++y)
        for (int x = 20; x < map.width; ++x) map(x, y).s += 3 * kBeamPx * kPitch;
    for (const CentreOfLight& centre : map.centres(0.58)) EXPECT_LT(centre.shift_px.norm(), 1e-6F);
    // Nor other lasers, other exposures or doubtful pulses.
    const std::function<void(Pulse&)> changes[] = {
        [](Pulse& p) { p.laser_id = 1; }, [](Pulse& p) { p.exposure_index = 1; },
        [](Pulse& p) { p.flags = kPulseOverlapping; }, [](Pulse& p) { p.amplitude = 0; }};
    for (const auto& change : changes) {
        map.fill([](int x, int) { return Seen{x < 20 ? 1.0 : 10.0, 0}; }, 0, 1);
        for (int y = 0; y < map.height; ++y)
            for (int x = 20; x < map.width; ++x) change(map(x, y));
        for (const CentreOfLight& centre : map.centres(0.58))
            EXPECT_LT(centre.shift_px.norm(), 1e-6F);
    }
}

TEST(CentreOfLight, AtTheEndOfASurfaceGoesInwards) {
    // The surface ends at column 20; the last pixel is covered by a third.
    constexpr double kFootprint = 0.58;
    Map map(40, 9);
    map.fill(
        [&](int x, int) {
            const double z = (19.75 - x) / kFootprint;
            return Seen{cumulative(z), -kFootprint * phi(z) / cumulative(z)};
        },
        0, 1);
    for (int y = 0; y < map.height; ++y)
        for (int x = 21; x < map.width; ++x) map(x, y).amplitude = 0;
    const auto centres = map.centres(kFootprint);
    for (int x = 19; x <= 20; ++x) {
        const double truth =
            kFootprint * phi((19.75 - x) / kFootprint) / cumulative((19.75 - x) / kFootprint);
        const double found = -static_cast<double>(centres[map.cell(x, 4)].shift_px.x());
        // Before the last pixel: differences between pixels. The last one: the pixel inwards is
        // not whole either.
        EXPECT_NEAR(found, truth, (x == 19 ? 0.7 : 0.1) * truth) << x;
    }
}

/// A surface that ends at `edge` (px, along u), seen by square pixels; beyond it nothing, or
/// another surface `behind` widths of the pulse on.
Map ending_at(double edge, double noise, double behind = 0) {
    Map map(40, 60);
    const auto share = [edge](int x) { return std::clamp(edge - (x - 0.5), 0.0, 1.0); };
    map.fill([&](int x, int) { return Seen{share(x), (share(x) - 1) / 2}; }, noise, 7);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (share(x) == 0) {
                map(x, y).amplitude = behind > 0 ? 100 : 0;
                map(x, y).s += behind * kBeamPx * kPitch;
            }
    return map;
}

TEST(PartlyLit, APixelsLightLiesInItsLitPart) {
    for (const double edge : {19.7, 19.9, 20.1, 20.4})
        for (const double behind : {0.0, 3.0}) {
            Map map = ending_at(edge, 0, behind);
            const auto centres = map.centres(0);
            for (int x = 0; x < map.width; ++x) {
                const CentreOfLight& centre = centres[map.cell(x, 30)];
                const double expected = x == 20 ? (edge - 20.5) / 2 : 0;
                // The root of 3 times that of 1 / 12 is a half to the last digits of a float.
                EXPECT_NEAR(static_cast<double>(centre.shift_px.x()), expected, 1e-5) << edge;
                EXPECT_EQ(centre.is_partly_lit, x == 20) << edge << ' ' << x;
                EXPECT_FLOAT_EQ(centre.shift_px.y(), 0);
            }
        }
}

TEST(PartlyLit, AGaussianFootprintGoesInwardsAsHalfAGaussianDoes) {
    for (const double footprint : {0.29, 0.42, 0.58})
        for (const double lit_from_middle : {-0.2, -0.1, 0.1, 0.2}) {  // px
            Map map(40, 9);
            const auto seen = [&](int x) {
                const double z = (20 + lit_from_middle - x) / footprint;
                return Seen{cumulative(z), -footprint * phi(z) / cumulative(z)};
            };
            map.fill([&](int x, int) { return seen(x); }, 0, 1);
            for (int y = 0; y < map.height; ++y)
                for (int x = 21; x < map.width; ++x) map(x, y).amplitude = 0;
            const double truth = seen(20).shift_px;
            // The linear form exceeds half a Gaussian's mean by up to sqrt(3 pi / 8) - 1, 9 %; for
            // the wider footprints the next pixel is not whole.
            EXPECT_NEAR(static_cast<double>(map.centres(footprint)[map.cell(20, 4)].shift_px.x()),
                        truth, (footprint < 0.5 ? 0.09 : 0.15) * std::abs(truth))
                << footprint << ' ' << lit_from_middle;
        }
}

TEST(PartlyLit, StatesTheScatterOfItsShift) {
    constexpr double kEdge = 19.9, kNoise = 0.03;
    Map map = ending_at(kEdge, kNoise);
    const auto centres = map.centres(0);
    double squares = 0;
    for (int y = 0; y < map.height; ++y) {
        const CentreOfLight& centre = centres[map.cell(20, y)];
        const double error = static_cast<double>(centre.shift_px.x()) - (kEdge - 20.5) / 2;
        EXPECT_LT(std::abs(error), 4 * static_cast<double>(centre.sigma_px.x()));
        squares += error * error;
    }
    // Noise alone: 0.4 / 2 of sqrt(0.03^2 (1 + 1..5)); the sigma stated holds the shape besides.
    EXPECT_LT(std::sqrt(squares / map.height), 0.02);
    EXPECT_NEAR(static_cast<double>(centres[map.cell(20, 30)].sigma_px.x()), 0.25 * 0.3, 0.02);
}

TEST(PartlyLit, NothingIsPartlyLitWhereOtherReasonsAreAsLikely) {
    const auto count = [](const Map& map) {
        std::size_t moved = 0;
        for (const CentreOfLight& centre : map.centres(0)) moved += centre.is_partly_lit;
        return moved;
    };
    // Darker by no more than the noise.
    Map even = ending_at(20.5, 0.03);
    EXPECT_LE(count(even), 1U);  // of 60: three standard deviations, one-sided
    // Shading that goes on as before: 0.8 from pixel to pixel.
    Map shaded = ending_at(20.5, 0);
    for (int y = 0; y < shaded.height; ++y)
        for (int x = 0; x <= 20; ++x)
            shaded(x, y).amplitude = 100 * static_cast<float>(std::pow(0.8, x - 10));
    EXPECT_EQ(count(shaded), 0U);
    // Texture, or speckle, of which every other pixel is as dark.
    Map speckled = ending_at(20.5, 0);
    for (int y = 0; y < speckled.height; ++y)
        for (int x = 0; x <= 20; ++x) speckled(x, y).amplitude = (x + y) % 2 == 0 ? 40 : 100;
    EXPECT_EQ(count(speckled), 0U);
    // A hole of one pixel.
    Map holed(20, 20);
    holed.fill([](int x, int) { return Seen{x == 9 ? 0.3 : 1.0, 0}; }, 0, 1);
    for (int y = 0; y < holed.height; ++y) holed(10, y).amplitude = 0;
    EXPECT_EQ(count(holed), 0U);
    // The border of the image; a neighbour with a warning, or of another exposure.
    Map darker(20, 20);
    darker.fill([](int x, int) { return Seen{x == 19 ? 0.3 : 1.0, 0}; }, 0, 1);
    EXPECT_EQ(count(darker), 0U);
    for (const bool warned : {false, true}) {
        Map beside = ending_at(20.0, 0, 0);
        for (int y = 0; y < beside.height; ++y) {
            Pulse& next = beside(21, y);
            next.amplitude = 50;
            if (warned)
                next.flags = kPulseOverlapping;
            else
                next.exposure_index = 1;
        }
        EXPECT_EQ(count(beside), 0U) << warned;
    }
}

TEST(Footprint, IsFoundWhereTextureShowsIt) {
    for (const double footprint : {0.42, 0.58, 0.8, 1.1})
        for (const double noise : {0.005, 0.03}) {
            Map map(400, 300);
            map.fill([&](int x, int y) { return slanted_stripes(x, y, 5, footprint); }, noise, 3);
            const auto found = estimate_footprint(map.chosen(), map.width, map.height);
            ASSERT_TRUE(found);
            std::printf("footprint %.2f px, noise %.3f: %.4f +- %.4f px\n", footprint, noise,
                        found->sigma_px, found->sigma_of_sigma_px);
            // Differences between pixels stand for gradients: 4 %.
            EXPECT_NEAR(found->sigma_px, footprint,
                        0.04 * footprint + 3 * found->sigma_of_sigma_px);
            EXPECT_LT(found->sigma_of_sigma_px, 0.05 * footprint);
        }
}

TEST(Footprint, IsNotInventedWithoutTexture) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Map map(200, 200);
        map.fill([](int, int) { return Seen{}; }, 0.05, seed);
        EXPECT_FALSE(estimate_footprint(map.chosen(), map.width, map.height)) << seed;
    }
    EXPECT_FALSE(estimate_footprint({}, 0, 0));
}

}  // namespace
}  // namespace stria

#include "host/scan/centre_of_light.h"

#include <gtest/gtest.h>

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
            map.fill([&](int x, int y) { return slanted_stripes(x, y, contrast, footprint); }, 0,
                     1);
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
        EXPECT_NEAR(found, truth, 0.7 * truth) << x;  // differences between pixels
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

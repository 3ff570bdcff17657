#include "sim/blooming.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

constexpr float kFull = 1000;

/// A Gaussian stripe of that height and standard deviation, centred on a pixel, as a sensor holds
/// it: what a pixel spilled is gone.
std::vector<float> held(float height, double sigma, float blooming) {
    std::vector<float> row(101);
    for (std::size_t i = 0; i < row.size(); ++i) {
        const double d = (static_cast<double>(i) - 50) / sigma;
        row[i] = height * static_cast<float>(std::exp(-d * d / 2));
    }
    spill_along_row(row, kFull, blooming);
    for (float& electrons : row) electrons = std::min(electrons, kFull);
    return row;
}

double sum_of(const std::vector<float>& row) {
    return std::accumulate(row.begin(), row.end(), 0.0);
}

TEST(Blooming, LosesNoChargeWhereNoneRunsOff) {
    const double light = 3500 * 2.5 * std::sqrt(2 * M_PI);         // of the whole stripe
    EXPECT_NEAR(sum_of(held(3500, 2.5, 1)), light, 1e-4 * light);  // float sums
    EXPECT_LT(sum_of(held(3500, 2.5, 0.5F)), light);
    EXPECT_GT(sum_of(held(3500, 2.5, 0.5F)), sum_of(held(3500, 2.5, 0)));
}

TEST(Blooming, WidensAStripeEvenlyToBothSides) {
    const std::vector<float> wide = held(3500, 2.5, 1);
    for (std::size_t i = 0; i <= 50; ++i) EXPECT_NEAR(wide[50 - i], wide[50 + i], 1e-2);
    // All of the light above the full well fills up the flanks from inside out: where the plateau
    // ends, plateau and what is left of the flank hold the whole light.
    int full = 0;
    for (float electrons : wide) full += electrons >= kFull ? 1 : 0;
    int clipped = 0;
    for (float electrons : held(3500, 2.5, 0)) clipped += electrons >= kFull ? 1 : 0;
    EXPECT_GT(full, clipped + 4);
}

TEST(Blooming, APacketShrinksByItsShareAtEveryPixel) {
    std::vector<float> row(9, kFull);  // full, so that none is taken on the way
    row[2] = kFull + 800;
    row[5] = row[6] = 0;
    spill_along_row(row, kFull, 0.5F);
    // Half goes right: 400, then 200 at pixel 3, 100 at 4, 50 arrive at 5.
    EXPECT_FLOAT_EQ(row[5], 50);
    EXPECT_FLOAT_EQ(row[6], 0);
    std::vector<float> dim = {1, 2, 900, 1000, 3};
    const std::vector<float> before = dim;
    spill_along_row(dim, kFull, 1);
    EXPECT_EQ(dim, before);
}

TEST(Blooming, IsSeenInFramesAndRefusedOutsideItsRange) {
    Scene scene = read_scene(example_scene("swept.toml"));
    scene.sensor.noise = false;
    const auto bright_pixels = [&] {
        SimulatedScanner scanner(scene, 1);
        const Frame frame = record_still(scanner, 0, 1, 4 * scene.sensor.exposure_us);
        int count = 0;
        for (int v = 0; v < frame.height; ++v)
            for (int u = 0; u < frame.width; ++u) count += frame.sample(u, v) > 200 ? 1 : 0;
        return count;
    };
    const int without = bright_pixels();
    scene.sensor.blooming = 0.9;
    EXPECT_GT(bright_pixels(), without * 11 / 10);
    scene.sensor.blooming = 1.1;
    EXPECT_NE(validate(scene).find("sensor.blooming"), std::string::npos);
}

}  // namespace
}  // namespace stria

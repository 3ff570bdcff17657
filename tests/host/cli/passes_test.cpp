#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "firmware/core/median.h"
#include "host/cli/recording_range.h"
#include "host/local/local_scanner.h"
#include "sim/scene.h"
#include "tests/sim/plate_scene.h"

/// Sweeps of several passes through simulator, device and range image: exposures for surfaces of
/// very different brightness, and both directions of the axis.
namespace stria {
namespace {

constexpr double kDepthMm = 450;

/// The built-in scanner, the middle of its image, before a bright plate, right half a 60th of it.
Scene two_tone() {
    Scene scene = built_in_scene();
    test::crop_to_middle(scene.channel.camera, 160, 60);
    SceneObject plate = test::plate(kDepthMm, 300);
    plate.size_mm = {150, 300};
    plate.albedo = 0.9;
    SceneObject dark = plate;
    dark.name = "dark";
    dark.corner_mm = {0, -150};
    dark.albedo = 0.015;
    scene.objects = {plate, dark};
    scene.ambient_level = 0.01;
    scene.axis.sigma = 0;  // a column's points would share its noise
    return scene;
}

ScanPlan sweep(std::vector<double> exposures_us) {
    ScanPlan plan;
    plan.mode = StripeMode::spacetime;
    plan.from = -0.03;
    plan.to = 0.075;
    plan.step = 0.00012;
    plan.exposures_us = std::move(exposures_us);
    return plan;
}

struct Half {
    std::size_t points = 0, saturated = 0;
    double rms_over_sigma = 0, median_sigma_mm = 0;
};

struct Halves {
    Half bright, dark;
};

/// The points of each half, away from the edge between them, against the plate.
Half measure(const RangeImage& image, int from, int to) {
    Half half;
    std::vector<double> sigmas;
    double squares = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = from; x < to; ++x) {
            if (!image.has(x, y)) continue;
            const RangePoint& point = image.at(x, y);
            const double along = std::abs(static_cast<double>(point.error_direction.z()));
            sigmas.push_back(static_cast<double>(point.sigma_mm) * along);
            squares += std::pow((point.position.z() + kDepthMm) / sigmas.back(), 2);
        }
    half.points = sigmas.size();
    if (sigmas.empty()) return half;
    half.rms_over_sigma = std::sqrt(squares / static_cast<double>(sigmas.size()));
    half.median_sigma_mm = median(std::move(sigmas));
    return half;
}

Halves scan(const std::vector<double>& exposures_us) {
    LocalScanner device(two_tone());
    const RecordingContents contents = device.run(sweep(exposures_us));
    const RangeResult result = range_of(contents, device.scanner().truth_model(), "plate");
    const RangeImage& image = result.image;
    const Halves halves = {measure(image, 10, 70), measure(image, 90, 150)};
    std::printf(
        "%zu exposures: bright %zu points, sigma %.4f mm, rms over it %.3f; dark %zu, %.4f, "
        "%.3f\n",
        exposures_us.size(), halves.bright.points, halves.bright.median_sigma_mm,
        halves.bright.rms_over_sigma, halves.dark.points, halves.dark.median_sigma_mm,
        halves.dark.rms_over_sigma);
    return halves;
}

TEST(Exposures, TogetherMeasureWhatNoneMeasuresAlone) {
    const Halves brief = scan({250}), long_one = scan({4500}), both = scan({250, 4500});
    // Pixels of a half: 3600.
    EXPECT_LT(brief.dark.points, 500U);  // too dark
    EXPECT_GT(both.bright.points, 3500U);
    EXPECT_GT(both.dark.points, 3500U);
    // Not worse than the better of the two, by more than the scatter of a median of sigmas.
    EXPECT_LT(both.bright.median_sigma_mm, 1.02 * brief.bright.median_sigma_mm);
    EXPECT_LT(both.dark.median_sigma_mm, 1.02 * long_one.dark.median_sigma_mm);
    EXPECT_GT(both.bright.rms_over_sigma, 0.9);
    EXPECT_LT(both.bright.rms_over_sigma, 1.1);
    EXPECT_GT(both.dark.rms_over_sigma, 0.9);
    EXPECT_LT(both.dark.rms_over_sigma, 1.1);
}

TEST(Directions, TellTheDelayOfTheAxisAndCorrectIt) {
    Scene scene = two_tone();
    scene.axis.lag_us = 150;
    LocalScanner device(scene);
    ScanPlan plan = sweep({2000});
    plan.both_directions = true;
    const RecordingContents contents = device.run(plan);
    const RangeResult range = range_of(contents, device.scanner().truth_model(), "plate");
    ASSERT_EQ(range.notes.size(), 2U);
    for (const std::string& text : range.notes) std::printf("%s\n", text.c_str());
    const std::string& note = range.notes[0];
    double delay_us = 0;
    ASSERT_EQ(std::sscanf(note.c_str(), "two directions of the axis: clock delay %lf", &delay_us),
              1);
    EXPECT_NEAR(delay_us, -150, 5);
    EXPECT_NE(note.find("corrected"), std::string::npos);
    const Half bright = measure(range.image, 10, 70);
    EXPECT_GT(bright.points, 3500U);
    EXPECT_LT(bright.rms_over_sigma, 1.4);

    plan.both_directions = false;
    const RangeResult one_way = range_of(device.run(plan), device.scanner().truth_model(), "plate");
    EXPECT_TRUE(one_way.notes.empty());
    EXPECT_GT(measure(one_way.image, 10, 70).rms_over_sigma, 3);  // it matters
}

}  // namespace
}  // namespace stria

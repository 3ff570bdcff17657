#include "firmware/session/feature_table.h"

#include <gtest/gtest.h>

#include "tests/firmware/acquire/fake_machine.h"

namespace stria {
namespace {

class Features : public testing::Test {
  protected:
    std::string refusal(const char* name, const FeatureValue& value) {
        const auto done = table.set(name, value);
        return done ? "" : done.failure().message;
    }
    FakeMachine machine;
    ServedDevice device{machine.devices()};
    DeviceSettings settings;
    FeatureTable table{common_features(device, settings)};
};

TEST_F(Features, EachHasADescriptionAndEachRangeAReason) {
    for (const Feature& feature : table.all()) {
        EXPECT_FALSE(feature.description.empty()) << feature.name;
        if (feature.range) {
            EXPECT_FALSE(feature.range->reason.empty()) << feature.name;
        }
    }
}

TEST_F(Features, ExposureLimitsTheFrameRate) {
    EXPECT_EQ(std::get<double>(table.get("AcquisitionFrameRate")->value), 500.0);
    ASSERT_TRUE(table.set("ExposureTime", 5000.0));
    const Feature rate = *table.get("AcquisitionFrameRate");
    EXPECT_EQ(std::get<double>(rate.value), 200.0);
    EXPECT_NE(rate.range->reason.find("ExposureTime"), std::string::npos);
    EXPECT_NE(refusal("AcquisitionFrameRate", 300.0).find("0.1 to 200 Hz"), std::string::npos);
    ASSERT_TRUE(table.set("AcquisitionFrameRate", 100.0));
    EXPECT_EQ(settings.acquire.frame_period_ns, 10 * kNsPerMs);
    EXPECT_EQ(settings.acquire.exposure_ns, 5 * kNsPerMs);
}

TEST_F(Features, RefusalsSayWhy) {
    EXPECT_NE(refusal("ExposureTime", 1.0).find("shortest and longest"), std::string::npos);
    EXPECT_NE(refusal("ExposureTime", std::string("long")).find("expected a number"),
              std::string::npos);
    EXPECT_EQ(refusal("Width", std::int64_t{3}), "Width can only be read");
    EXPECT_NE(refusal("Exposuretime", 1.0).find("nearest is \"ExposureTime\""), std::string::npos);
    EXPECT_EQ(settings.acquire.exposure_ns, kNsPerMs);
}

TEST_F(Features, WholeNumbersAreNumbersToo) {
    ASSERT_TRUE(table.set("ExposureTime", std::int64_t{2000}));
    EXPECT_EQ(settings.acquire.exposure_ns, 2 * kNsPerMs);
}

TEST_F(Features, FastSpacetimeIsForSurfacePointsOf8Bits) {
    ASSERT_EQ(std::get<bool>(table.get("FastSpacetime")->value), false);
    ASSERT_TRUE(table.set("FastSpacetime", true));
    EXPECT_TRUE(settings.acquire.spacetime.fast);
    EXPECT_EQ(std::get<bool>(table.get("FastSpacetime")->value), true);
    ASSERT_TRUE(table.set("FastSpacetime", std::int64_t{0}));
    EXPECT_FALSE(settings.acquire.spacetime.fast);
    EXPECT_NE(refusal("FastSpacetime", 0.5).find("expected true or false"), std::string::npos);
}

TEST_F(Features, FastSpacetimeOfAMachineWithImagePathsSaysWhyNot) {
    DeviceSettings rail;
    rail.acquire.spacetime_per_pixel = false;
    rail.acquire.spacetime.fast = true;  // asked for, and of no effect
    FeatureTable of_rail(common_features(device, rail));
    EXPECT_EQ(std::get<bool>(of_rail.get("FastSpacetime")->value), false);
    const auto done = of_rail.set("FastSpacetime", true);
    ASSERT_FALSE(done);
    EXPECT_NE(done.failure().message.find("expected 0 to 0 (this machine moves the part"),
              std::string::npos)
        << done.failure().message;
}

TEST_F(Features, FastSpacetimeOfAnotherDepthSaysThatTheReferenceAnalyses) {
    CameraInfo camera;
    for (const int bits : {10, 12, 16}) {
        camera.bits = bits;
        EXPECT_NE(why_not_fast(camera, {})
                      .find("8 bits; the reference analyses this camera's " + std::to_string(bits)),
                  std::string::npos);
    }
    camera.bits = 8;
    EXPECT_EQ(why_not_fast(camera, {}), "");
}

}  // namespace
}  // namespace stria

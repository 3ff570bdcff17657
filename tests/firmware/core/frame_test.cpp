#include "firmware/core/frame.h"

#include <gtest/gtest.h>

#include "firmware/core/sensor_noise.h"

namespace stria {
namespace {

TEST(Frame, TakesOneByteASampleUpToEightBits) {
    Frame frame;
    resize(frame, 5, 3, 8);
    EXPECT_EQ(frame.bytes.size(), 15U);
    EXPECT_EQ(frame.full_scale(), 255);
    frame.bytes[5 * 2 + 4] = 77;
    EXPECT_EQ(frame.sample(4, 2), 77);
    EXPECT_EQ(frame.view8().at(4, 2), 77);
}

TEST(Frame, TakesTwoBytesAboveEightBits) {
    Frame frame;
    resize(frame, 5, 3, 12);
    EXPECT_EQ(frame.bytes.size(), 30U);
    EXPECT_EQ(frame.full_scale(), 4095);
    frame.bytes[2 * (5 * 1 + 3)] = 0x34;  // little endian
    frame.bytes[2 * (5 * 1 + 3) + 1] = 0x02;
    EXPECT_EQ(frame.sample(3, 1), 0x234);
    EXPECT_EQ(frame.view16().row(1)[3], 0x234);
}

TEST(Frame, KnowsTheMiddleOfARowsExposure) {
    Frame frame;
    frame.exposure_start_ns = 1'000'000;
    frame.exposure_ns = 2'000;
    frame.row_time_ns = 15;
    EXPECT_EQ(frame.row_time(0), 1'001'000);
    EXPECT_EQ(frame.row_time(100), 1'002'500);
}

TEST(ImageView, StepsByItsStride) {
    const std::uint8_t pixels[12] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    const ImageView<const std::uint8_t> view{pixels + 1, 2, 3, 4};  // 2 x 3 out of 4 x 3
    EXPECT_EQ(view.at(0, 0), 1);
    EXPECT_EQ(view.at(1, 2), 10);
    EXPECT_FALSE(view.empty());
    EXPECT_TRUE((ImageView<const std::uint8_t>{}).empty());
}

TEST(SensorNoise, IsLinearInTheLight) {
    const SensorNoise noise{.gain_e_per_dn = 50, .read_noise_e = 10, .black_dn = 16};
    // Photons: (DN - black) / gain; reading (10 / 50)^2; quantisation 1/12
    EXPECT_NEAR(sample_variance(noise, 116), 2.0 + 0.04 + 1.0 / 12, 1e-12);
    EXPECT_NEAR(sample_variance(noise, 16), 0.04 + 1.0 / 12, 1e-12);
    EXPECT_NEAR(sample_variance(noise, 0), 0.04 + 1.0 / 12, 1e-12);  // below black: no light
}

}  // namespace
}  // namespace stria

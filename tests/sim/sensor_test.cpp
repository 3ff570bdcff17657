#include "sim/sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace stria {
namespace {

SceneSensor plain_sensor() {
    SceneSensor sensor;
    sensor.full_well_e = 1e6;
    sensor.read_noise_e = 0;
    sensor.gain_e_per_dn = 1;
    sensor.bits = 16;
    return sensor;
}

std::vector<int> samples(const SceneSensor& sensor, float electrons, std::size_t count,
                         std::int64_t frame = 0) {
    const std::vector<float> light(count, electrons);
    std::vector<std::uint8_t> bytes(count * 2);
    digitise(sensor, noise_key(7, 0, frame), 0, light, bytes.data());
    std::vector<int> dn(count);
    for (std::size_t i = 0; i < count; ++i) {
        std::uint16_t wide = 0;
        std::memcpy(&wide, &bytes[2 * i], 2);
        dn[i] = sensor.bits > 8 ? wide : bytes[i];
    }
    return dn;
}

struct Moments {
    double mean = 0, variance = 0, skew = 0, kurtosis = 0;
};

Moments moments(const std::vector<int>& values) {
    const auto n = static_cast<double>(values.size());
    Moments m;
    for (int v : values) m.mean += v / n;
    double third = 0, fourth = 0;
    for (int v : values) {
        const double d = v - m.mean;
        m.variance += d * d / n;
        third += d * d * d / n;
        fourth += d * d * d * d / n;
    }
    m.skew = third / std::pow(m.variance, 1.5);
    m.kurtosis = fourth / (m.variance * m.variance);
    return m;
}

constexpr std::size_t kMany = 400000;

// Photon transfer (EMVA 1288): variance over mean is 1 / (electrons per DN).
TEST(Sensor, PhotonTransferSlopeIsTheGain) {
    SceneSensor sensor = plain_sensor();
    sensor.gain_e_per_dn = 4;
    sensor.bits = 12;
    sensor.read_noise_e = 6;
    const Moments dark = moments(samples(sensor, 400, kMany));
    for (float electrons : {1000.0F, 3000.0F, 6000.0F, 12000.0F}) {
        const Moments m = moments(samples(sensor, electrons, kMany, 1));
        const double slope = (m.variance - dark.variance) / (m.mean - dark.mean);
        // 400 000 samples give the slope to 0.3 %.
        EXPECT_NEAR(slope * sensor.gain_e_per_dn, 1.0, 0.02) << electrons;
        EXPECT_NEAR(m.mean * sensor.gain_e_per_dn, static_cast<double>(electrons), 1.0);
    }
}

TEST(Sensor, DimLightIsPoisson) {
    for (float mean : {0.3F, 2.0F, 12.0F, 29.0F}) {
        const Moments m = moments(samples(plain_sensor(), mean, kMany));
        const double mu = static_cast<double>(mean);
        const double error = std::sqrt(mu / static_cast<double>(kMany));
        EXPECT_NEAR(m.mean, mu, 4 * error) << mean;
        // Variance of a variance: (mu + 2 mu^2) / n.
        EXPECT_NEAR(m.variance, mu, 4 * std::sqrt((mu + 2 * mu * mu) / kMany)) << mean;
        EXPECT_NEAR(m.skew, 1 / std::sqrt(mu), 0.05) << mean;
    }
}

TEST(Sensor, BrightLightIsNormal) {
    const Moments m = moments(samples(plain_sensor(), 10000, kMany));
    EXPECT_NEAR(m.mean, 10000, 0.7);           // 4 standard errors of 0.16
    EXPECT_NEAR(m.variance / 10000, 1, 0.01);  // 4 x sqrt(2 / n)
    EXPECT_NEAR(m.skew, 0, 0.016);             // 4 x sqrt(6 / n)
    EXPECT_NEAR(m.kurtosis, 3, 0.031);         // 4 x sqrt(24 / n)
}

TEST(Sensor, ReadNoiseAloneInTheDark) {
    SceneSensor sensor = plain_sensor();
    sensor.read_noise_e = 9;
    sensor.black_dn = 100;
    const Moments m = moments(samples(sensor, 0, kMany));
    EXPECT_NEAR(m.mean, 100, 0.06);
    EXPECT_NEAR(m.variance, 81 + 1.0 / 12, 0.8);  // rounding adds 1/12
}

TEST(Sensor, WithoutNoiseRoundsToTheNearest) {
    SceneSensor sensor = plain_sensor();
    sensor.noise = false;
    sensor.gain_e_per_dn = 40;
    sensor.black_dn = 4;
    EXPECT_EQ(samples(sensor, 0, 3), std::vector<int>(3, 4));
    EXPECT_EQ(samples(sensor, 19.9F, 3), std::vector<int>(3, 4));
    EXPECT_EQ(samples(sensor, 20.1F, 3), std::vector<int>(3, 5));
    EXPECT_EQ(samples(sensor, 4000, 3), std::vector<int>(3, 104));
}

TEST(Sensor, ClipsAtFullWellAndAtFullScale) {
    SceneSensor sensor = plain_sensor();
    sensor.bits = 8;
    sensor.gain_e_per_dn = 40;
    EXPECT_EQ(samples(sensor, 1e5F, 1000), std::vector<int>(1000, 255));
    sensor.full_well_e = 8000;  // 200 DN
    for (int dn : samples(sensor, 1e5F, 1000)) EXPECT_EQ(dn, 200);
}

TEST(Sensor, SameNumbersHoweverAFrameIsCut) {
    SceneSensor sensor = plain_sensor();
    sensor.read_noise_e = 5;
    std::vector<float> light;
    for (int i = 0; i < 3001; ++i) light.push_back(static_cast<float>(i % 700));
    std::vector<std::uint8_t> whole(light.size() * 2), cut(light.size() * 2),
        portable(light.size() * 2);
    const NoiseKey key = noise_key(3, 2, 9);
    digitise(sensor, key, 0, light, whole.data());
    for (std::size_t at = 0; at < light.size(); at += 97) {
        const std::size_t count = std::min<std::size_t>(97, light.size() - at);
        digitise(sensor, key, static_cast<std::uint32_t>(at), {light.data() + at, count},
                 cut.data() + 2 * at);
    }
    digitise_portably(sensor, key, 0, light, portable.data());
    EXPECT_EQ(whole, cut);
    EXPECT_EQ(whole, portable);  // to the bit, whatever the processor's vectors
}

TEST(Sensor, FramesViewsAndSeedsAreIndependent) {
    const SceneSensor sensor = plain_sensor();
    const std::vector<float> light(20000, 1000);
    const auto deviations = [&](NoiseKey key) {
        std::vector<std::uint8_t> bytes(light.size() * 2);
        digitise(sensor, key, 0, light, bytes.data());
        std::vector<double> d(light.size());
        for (std::size_t i = 0; i < d.size(); ++i) {
            std::uint16_t dn = 0;
            std::memcpy(&dn, &bytes[2 * i], 2);
            d[i] = (dn - 1000) / std::sqrt(1000.0);
        }
        return d;
    };
    const std::vector<double> base = deviations(noise_key(1, 0, 0));
    for (const NoiseKey& key : {noise_key(1, 0, 1), noise_key(1, 1, 0), noise_key(2, 0, 0)}) {
        const std::vector<double> other = deviations(key);
        double same = 0, shifted = 0;
        for (std::size_t i = 0; i + 1 < base.size(); ++i) {
            same += base[i] * other[i] / static_cast<double>(base.size());
            shifted += base[i] * other[i + 1] / static_cast<double>(base.size());
        }
        EXPECT_LT(std::abs(same), 0.028);  // 4 / sqrt(n)
        EXPECT_LT(std::abs(shifted), 0.028);
    }
}

}  // namespace
}  // namespace stria

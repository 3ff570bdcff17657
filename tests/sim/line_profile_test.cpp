#include "sim/line_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/beam.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

constexpr double kFan = 0.9;

TEST(LineProfile, KeepsThePowerWhateverItsShape) {
    for (const SceneLine& line :
         {SceneLine{}, SceneLine{.ripple = 0.3, .ripple_rad = 0.07}, SceneLine{.falloff_rad = 0.2},
          SceneLine{.ripple = 0.9, .ripple_rad = 1.3, .falloff_rad = 0.4}}) {
        const LineProfile profile(line, kFan);
        double sum = 0;
        constexpr int kPoints = 100000;
        for (int i = 0; i < kPoints; ++i) sum += profile.at(((i + 0.5) / kPoints - 0.5) * kFan);
        EXPECT_NEAR(sum / kPoints, 1, 1e-5);
    }
}

TEST(LineProfile, FallsAndWavesAsItSays) {
    EXPECT_EQ(LineProfile({}, kFan).at(0.3), 1);
    const LineProfile fall({.falloff_rad = 0.2}, kFan);
    EXPECT_NEAR(fall.at(0.2) / fall.at(0), std::exp(-0.5), 1e-12);
    // Peak over the mean: fan / (sqrt(2 pi) sigma erf(fan / (2 sqrt 2 sigma))).
    const double area =
        std::sqrt(2 * std::numbers::pi) * 0.2 * std::erf(kFan / (2 * std::numbers::sqrt2 * 0.2));
    EXPECT_NEAR(fall.at(0), kFan / area, 1e-6);
    const LineProfile waves({.ripple = 0.25, .ripple_rad = 0.1}, kFan);
    EXPECT_NEAR(waves.at(0.1) / waves.at(0.05), 1.25 / 0.75, 1e-9);
}

TEST(LineProfile, DecidesWhatPixelsGet) {
    Scene even = built_in_scene();
    Scene uneven = even;
    uneven.line = {.ripple = 0.4, .ripple_rad = 0.2, .falloff_rad = 0.3};
    const LineProfile profile(uneven.line, even.channel.sheet.fan_rad);
    const Beam a(even), b(uneven);
    SurfaceHit hit;
    hit.normal = Eigen::Vector3f::UnitZ();
    hit.albedo = 0.7F;
    int compared = 0;
    for (double y = -120; y <= 120; y += 15) {
        hit.point = {10, y, -400};
        const auto one = a.passing(hit, 0), other = b.passing(hit, 0);
        ASSERT_TRUE(one && other);
        if (one->rate <= 0) continue;
        const LaserSheet sheet = sheet_at(even.channel, one->position);
        const Eigen::Vector3d p = scan_from_camera(even.channel, 0).inverse() * hit.point;
        // The mirrored sheet counts its fan angle the other way round; the profile is even.
        EXPECT_NEAR(other->rate / one->rate, profile.at(fan_angle(sheet, p)), 1e-6) << y;
        EXPECT_EQ(one->position, other->position);
        ++compared;
    }
    EXPECT_GT(compared, 8);
}

TEST(Wobble, MovesEachFrameByItsOwnAmount) {
    Scene scene = built_in_scene();
    scene.objects.resize(2);  // sphere and plate
    scene.objects.erase(scene.objects.begin());
    scene.channel.camera.width = 200;
    scene.channel.camera.height = 40;
    scene.channel.camera.cx = 100;
    scene.channel.camera.cy = 20;
    scene.sensor.noise = false;
    scene.sensor.bits = 16;
    scene.sensor.gain_e_per_dn = 0.2;
    scene.ambient_level = 0;
    scene.sensor.black_dn = 0;
    const auto centre = [&](SimulatedScanner& scanner, double s) {
        const Frame frame = record_still(scanner, s, 0.2F);
        double sum = 0, first = 0;
        for (int u = 0; u < frame.width; ++u) {
            sum += frame.sample(u, 20);
            first += frame.sample(u, 20) * u;
        }
        return first / sum;
    };
    SimulatedScanner steady(scene, 1);
    const double here = centre(steady, 0);
    const double px_per_s = (centre(steady, 0.001) - centre(steady, -0.001)) / 0.002;
    ASSERT_GT(std::abs(px_per_s), 100);
    const double wobble = 5e-4;
    scene.axis.wobble = wobble;
    SimulatedScanner shaky(scene, 1);
    constexpr int kFrames = 300;
    double sum = 0, square = 0;
    for (int k = 0; k < kFrames; ++k) {
        const double off = (centre(shaky, 0) - here) / px_per_s;
        sum += off;
        square += off * off;
    }
    EXPECT_NEAR(std::sqrt(square / kFrames), wobble, 0.15 * wobble);  // chance: 4 %
    EXPECT_NEAR(sum / kFrames, 0, 4 * wobble / std::sqrt(kFrames));
    scene.axis.wobble = -1;
    EXPECT_NE(validate(scene).find("axis.wobble"), std::string::npos);
    scene.axis.wobble = 0;
    scene.line.ripple = 1;
    EXPECT_NE(validate(scene).find("laser.ripple"), std::string::npos);
}

}  // namespace
}  // namespace stria

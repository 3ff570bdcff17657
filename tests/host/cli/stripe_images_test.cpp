#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "host/cli/run.h"
#include "host/cli/stripe_colour.h"
#include "host/cli/stripe_input.h"
#include "host/cli/stripe_profile.h"
#include "host/io/image_io.h"
#include "host/io/whole_file.h"
#include "tests/host/io/temporary_folder.h"

/// Photographs of a red stripe in lit, coloured scenes, made here: places are known.
namespace stria {
namespace {

constexpr int kWidth = 120, kHeight = 60;
constexpr double kStripe = 40.3, kEdge = 90.0, kSigma = 1.5;

double bell(double x, double at) { return std::exp(-0.5 * std::pow((x - at) / kSigma, 2)); }

struct Scene {
    double laser = 0, edge = 0;  // heights in DN of the red stripe and of a white bright line
    double texture = 0;          // DN of the background's dark patches
    unsigned seed = 1;
};

/// Red stripe at kStripe, white line at kEdge, over grey 60 with patches that cut the stripe.
ColourImage photograph(const Scene& scene) {
    ColourImage image(kWidth, kHeight, 3);
    std::mt19937 random(scene.seed);
    std::normal_distribution<double> noise(0, 1.5);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double patch = x < 41 && (y / 6) % 2 == 0 ? scene.texture : 0;
            const double white = 60 + scene.texture - patch + scene.edge * bell(x, kEdge);
            // A laser leaks a little into the other channels of a camera.
            for (int c = 0; c < 3; ++c) {
                const double red = scene.laser * bell(x, kStripe) * (c == 0 ? 1.0 : 0.15);
                image.at(x, y, c) = static_cast<std::uint8_t>(
                    std::clamp(std::lround(white + red + noise(random)), 0L, 255L));
            }
        }
    return image;
}

int stria(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv = {"stria"};
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    return run_program(static_cast<int>(argv.size()), argv.data());
}

std::vector<double> places_in(const std::string& csv) {
    std::istringstream in(read_whole_file(csv));
    std::string line;
    std::getline(in, line);
    std::vector<double> places;
    while (std::getline(in, line)) places.push_back(std::stod(line.substr(line.find(',') + 1)));
    return places;
}

double worst_of(const std::vector<double>& places) {
    double worst = 0;
    for (const double u : places) worst = std::max(worst, std::abs(u - kStripe));
    return worst;
}

TEST(LaserColour, KeepsTheRedStripeAndDropsTheWhiteLine) {
    const TemporaryFolder folder;
    for (const double laser : {80.0, 400.0}) {  // 400: clipped, its middle washed out
        write_png(folder / "image.png", photograph({.laser = laser, .edge = 120}));
        ASSERT_EQ(stria({"stripe", folder / "image.png", "--out", folder / "kept.csv", "--quiet",
                         "--force"}),
                  0);
        ASSERT_EQ(stria({"stripe", folder / "image.png", "--any-colour", "--out",
                         folder / "all.csv", "--quiet", "--force"}),
                  0);
        const std::vector<double> kept = places_in(folder / "kept.csv");
        EXPECT_GE(kept.size(), 59U);
        EXPECT_LT(worst_of(kept), 1.0);
        const std::vector<double> all = places_in(folder / "all.csv");
        EXPECT_GE(
            std::count_if(all.begin(), all.end(), [](double u) { return std::abs(u - kEdge) < 1; }),
            50);
    }
}

TEST(LaserColour, IsTheChannelThatStandsOutAndNoneInGreyScenes) {
    const TemporaryFolder folder;
    write_png(folder / "red.png", photograph({.laser = 80, .edge = 90}));
    EXPECT_EQ(laser_colour(read_image(folder / "red.png")), ColourChannel::red);
    ColourImage grey(kWidth, kHeight, 3, 60);
    for (int y = 0; y < kHeight; ++y)
        for (int c = 0; c < 3; ++c) grey.at(50, y, c) = 200;
    write_png(folder / "grey.png", grey);
    const LoadedImage image = read_image(folder / "grey.png");
    EXPECT_EQ(laser_colour(image), ColourChannel::grey);
    Pulse peak;
    peak.u = 50;
    peak.v = 20;
    peak.width = 0.5f;
    peak.amplitude = 140;
    EXPECT_TRUE(LaserColour(image, laser_colour(image), false).has(peak));
    EXPECT_FALSE(LaserColour(image, ColourChannel::red, false).has(peak));
    EXPECT_TRUE(LaserColour().has(peak));
}

TEST(StripeOff, SubtractedLightTakesTextureAwayAndSaysSoInTheNoise) {
    const TemporaryFolder folder;
    for (int i = 0; i < 4; ++i) {
        const auto seed = static_cast<unsigned>(10 + i);
        write_png(folder / ("on" + std::to_string(i) + ".png"),
                  photograph({.laser = 80, .edge = 90, .texture = 50, .seed = seed}));
        write_png(folder / ("off" + std::to_string(i) + ".png"),
                  photograph({.laser = 0, .edge = 90, .texture = 50, .seed = seed + 50}));
    }
    // Noise of 1.5 DN and no shot noise: 1e9 e-/DN.
    const std::vector<std::string> plain = {
        "stripe", folder / "on0.png", "--noise", "1e9,1.5e9", "--channel",
        "red",    "--quiet",          "--out"};
    auto with = [&](const std::string& csv, std::vector<std::string> more) {
        std::vector<std::string> arguments = plain;
        arguments.push_back(folder / csv);
        arguments.insert(arguments.end(), more.begin(), more.end());
        EXPECT_EQ(stria(arguments), 0);
        return places_in(folder / csv);
    };
    const std::vector<double> textured = with("plain.csv", {});
    const std::vector<double> one = with("one.csv", {"--off", folder / "off0.png"});
    const std::vector<double> mean =
        with("mean.csv", {"--off", folder / "off0.png", folder / "off1.png", folder / "off2.png"});
    // sigma at height 80, width 1.5, noise 1.5 sqrt(2): 0.036 px; five of it
    EXPECT_EQ(one.size(), 60U);
    EXPECT_LT(worst_of(one), 0.18);
    EXPECT_LT(worst_of(mean), 0.18);
    std::printf("textured: %zu peaks, worst %.3f px\n", textured.size(), worst_of(textured));
    EXPECT_TRUE(textured.size() < 40 || worst_of(textured) > 0.4);  // half the rows have a step

    StripeImages paired({folder / "on0.png", folder / "on1.png"},
                        {.channel = "red", .off = {folder / "off0.png", folder / "off1.png"}});
    SensorNoise sensor;
    sensor.gain_e_per_dn = 1e9;
    sensor.read_noise_e = 1.5e9;
    const SensorNoise noise = paired.noise_of(sensor);
    EXPECT_NEAR(noise.read_noise_e / noise.gain_e_per_dn, 1.5 * std::sqrt(2.0), 1e-3);
    EXPECT_EQ(noise.black_dn, paired.pedestal_dn());
    const SensorNoise estimated = paired.estimated_noise();
    EXPECT_NEAR(estimated.read_noise_e / estimated.gain_e_per_dn, 1.5 * std::sqrt(2.0), 0.25);
}

TEST(StripeOff, ClippedPeaksKeepTheirFlag) {
    const TemporaryFolder folder;
    write_png(folder / "on.png", photograph({.laser = 300}));
    write_png(folder / "off.png", photograph({}));
    StripeImages images({folder / "on.png"}, {.channel = "red", .off = {folder / "off.png"}});
    const StripeImage image = images.load(0);
    Pulse peak;
    peak.u = static_cast<float>(kStripe);
    peak.v = 30;
    peak.width = 1.5f;
    EXPECT_TRUE(image.clipped(peak));
    peak.u = 90;
    EXPECT_FALSE(image.clipped(peak));
}

TEST(StripeOff, BadInputIsRefused) {
    const TemporaryFolder folder;
    write_png(folder / "on.png", photograph({.laser = 80}));
    write_png(folder / "small.png", ColourImage(20, 20, 3, 9));
    testing::internal::CaptureStderr();
    EXPECT_NE(stria({"stripe", folder / "on.png", "--off", folder / "small.png", "--out",
                     folder / "x.csv"}),
              0);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("expected 120 x 60 pixels"),
              std::string::npos);
    testing::internal::CaptureStderr();
    EXPECT_NE(stria({"stripe", folder / "on.png", folder / "on.png", "--mode", "spacetime", "--off",
                     folder / "on.png", "--out", folder / "x.csv"}),
              0);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("--off: expected --mode spatial"),
              std::string::npos);
}

TEST(StripeProfile, MediansOfBandsAlongTheStripe) {
    StripeProfile profile(100);
    for (int v = 0; v < 100; ++v) {
        Pulse peak;
        peak.v = static_cast<float>(v);
        peak.width = v < 50 ? 1.0f : 3.0f;
        peak.sigma = 0.1f;
        peak.amplitude = 50;
        peak.flags = v == 3 ? kPulseSaturated : 0;
        profile.add(peak);
    }
    const std::vector<StripeProfile::Band> bands = profile.bands();
    ASSERT_EQ(bands.size(), 8U);
    std::size_t peaks = 0;
    for (std::size_t i = 0; i < bands.size(); ++i) {
        EXPECT_EQ(bands[i].from, i == 0 ? 0 : bands[i - 1].to);
        EXPECT_EQ(bands[i].peaks, static_cast<std::size_t>(bands[i].to - bands[i].from));
        peaks += bands[i].peaks;
        EXPECT_EQ(bands[i].width, i < 4 ? 1.0 : 3.0);
    }
    EXPECT_EQ(peaks, 100U);
    EXPECT_EQ(bands[0].flagged, 1U);
    EXPECT_TRUE(std::isnan(StripeProfile(10).bands()[0].width));
}

/// Photographs of a circle-grid board with a red line across it, each once without the line.
TEST(StripeOff, RealBoardsShowTheLineAlone) {
    const char* root = std::getenv("STRIA_TEST_DATA");
    if (!root) GTEST_SKIP() << "set STRIA_TEST_DATA to the folder with laser_plane_circlegrid";
    const std::string data = std::string(root) + "/laser_plane_circlegrid/";
    const TemporaryFolder folder;
    ASSERT_EQ(stria({"stripe", data + "light0.jpg", "--axis", "columns", "--channel", "green",
                     "--off", data + "calib0.jpg", "--quiet", "--out", folder / "x.csv"}),
              0);
    std::istringstream in(read_whole_file(folder / "x.csv"));
    std::string line;
    std::getline(in, line);
    int on = 0, beside = 0;
    while (std::getline(in, line)) {
        double u = 0, v = 0;
        EXPECT_EQ(std::sscanf(line.c_str() + line.find(','), ",%lf,%lf", &u, &v), 2);
        // The line was read off the picture: from (345, 594) to (1120, 596).
        ++(u < 1130 && std::abs(v - (594 + (u - 345) * 2 / 775)) < 6 ? on : beside);
    }
    EXPECT_GT(on, 400);
    EXPECT_LE(beside, 25);
}

}  // namespace
}  // namespace stria

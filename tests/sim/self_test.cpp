#include <gtest/gtest.h>

#include <cmath>

#include "firmware/stripe/spatial.h"
#include "host/core/laser_sheet.h"
#include "tests/firmware/stripe/localisation.h"
#include "tests/sim/plate_scene.h"
#include "tests/sim/sim_sweep.h"

// What a simulator must show before anything is claimed with it.
namespace stria {
namespace {

/// A plate square to a camera of 96 x 200 pixels, 400 mm away; 12 bits.
Scene plate_scene() {
    Scene scene = built_in_scene();
    scene.channel.camera = test::pinhole(96, 200, 1150);
    scene.sensor.bits = 12;
    scene.sensor.gain_e_per_dn = 4;
    scene.sensor.full_well_e = 15000;
    scene.sensor.read_noise_e = 12;
    scene.sensor.black_dn = 100;
    scene.channel.sheet.bow2 = scene.channel.sheet.bow3 = 0;
    scene.objects = {test::plate(400)};
    return scene;
}

struct MeanAndVariance {
    double mean = 0, variance = 0;
};

/// Of pixels of pairs of frames: half the variance of their difference, so that what is fixed in
/// the picture does not count (EMVA 1288).
MeanAndVariance of_pairs(SimulatedScanner& scanner, double exposure_us, int pairs) {
    MeanAndVariance result;
    double count = 0;
    for (int k = 0; k < pairs; ++k) {
        const Frame a = record_still(scanner, 0, 0, exposure_us);
        const Frame b = record_still(scanner, 0, 0, exposure_us);
        for (int y = 0; y < a.height; ++y)
            for (int x = 0; x < a.width; ++x) {
                const double d = a.sample(x, y) - b.sample(x, y);
                result.mean += (a.sample(x, y) + b.sample(x, y)) / 2.0;
                result.variance += d * d / 2;
                ++count;
            }
    }
    result.mean /= count;
    result.variance /= count;
    return result;
}

// Slope of variance over mean: 1 / (electrons per DN) within 2 %; intercept: the read noise within
// 5 %. With a fixed pattern and vignetting, which must not count.
TEST(SelfTest, PhotonTransferOfFramesGivesGainAndReadNoise) {
    Scene scene = plate_scene();
    scene.ambient_level = 0.1;  // 1500 e at 1 ms
    scene.sensor.prnu = 0.01;
    scene.lens.corner_loss = 0.2;
    SimulatedScanner scanner(scene, 3);
    const MeanAndVariance dark = of_pairs(scanner, 1, 8);
    for (double exposure_us : {1000.0, 3000.0, 6000.0}) {
        const MeanAndVariance lit = of_pairs(scanner, exposure_us, 8);
        const double slope = (lit.variance - dark.variance) / (lit.mean - dark.mean);
        EXPECT_NEAR(slope * scene.sensor.gain_e_per_dn, 1, 0.02) << exposure_us;
    }
    // 1 us of ambient light: 1.2 e; rounding 1/12.
    const double read_e = 4 * std::sqrt(dark.variance - 1.0 / 12 - 1.2 / 16);
    EXPECT_NEAR(read_e, scene.sensor.read_noise_e, 0.05 * scene.sensor.read_noise_e);
}

/// Column where the sheet meets the plate in row v (closed form), axis at rest at s = 0.
double true_column(const Scene& scene, double v) {
    const CameraModel& camera = scene.channel.camera;
    const LaserSheet sheet = sheet_at(scene.channel, 0);
    const double y = (v - camera.cy) / camera.fy * 400;
    const double x =
        (sheet.offset_mm - sheet.normal.y() * y - sheet.normal.z() * 400) / sheet.normal.x();
    return camera.fx * x / 400 + camera.cx;
}

TEST(SelfTest, MaximumLikelihoodReachesTheBoundOnRenderedFrames) {
    Scene scene = plate_scene();
    scene.ambient_level = 0.02;
    scene.channel.sheet.waist_sigma_mm = 0.5;
    scene.channel.camera.cx += 47.5 - true_column(scene, 99.5);
    const LaserSheet sheet = sheet_at(scene.channel, 0);
    const double width_px =
        0.5 / (std::abs(sheet.normal.x()) * 400 / scene.channel.camera.fx);  // far from spreading
    const auto row_light = [&] {
        Scene quiet = scene;
        quiet.sensor.noise = false;
        quiet.ambient_level = 0;
        SimulatedScanner scanner(quiet, 1);
        const Frame frame = record_still(scanner, 0, 1);
        double sum = 0;
        for (int x = 0; x < frame.width; ++x) sum += frame.sample(x, 100) - 100;
        return sum;
    };
    scene.laser_power_mw = 1;
    scene.laser_power_mw *= 400 * width_px * std::sqrt(2 * M_PI) / row_light();  // 400 DN high
    test::TruePulse truth{row_light() / (width_px * std::sqrt(2 * M_PI)), 0, width_px,
                          100 + 0.02 * full_scale_e(scene.sensor) * scene.objects[0].albedo / 4};
    ASSERT_NEAR(truth.amplitude, 400, 20);
    const SensorNoise noise{.gain_e_per_dn = 4, .read_noise_e = 12, .black_dn = 100};
    std::vector<double> x(96);
    for (int i = 0; i < 96; ++i) x[static_cast<std::size_t>(i)] = i;

    SimulatedScanner scanner(scene, 1);
    test::LocalisationTally tally;
    for (int k = 0; k < 60; ++k) {
        const Frame frame = record_still(scanner, 0, 1);
        for (const Pulse& p : find_peaks(frame, noise, {.max_peaks_per_row = 1})) {
            truth.position = true_column(scene, static_cast<double>(p.v));
            tally.add(static_cast<double>(p.u) - truth.position, static_cast<double>(p.sigma),
                      test::cramer_rao_bound(truth, x, 0.5, noise));
        }
    }
    const test::LocalisationCell cell = tally.cell();
    std::printf("width %.2f px, bound %.4f px, rms / bound %.4f, mean %.5f px, %d rows\n", width_px,
                cell.bound, cell.ratio(), cell.mean, cell.trials);
    EXPECT_EQ(cell.trials, 12000);
    EXPECT_GT(cell.ratio(), 0.97);
    EXPECT_LT(cell.ratio(), 1.05);
}

TEST(SelfTest, TrueRangeTriangulatesToItself) {
    for (const char* name : {"swept.toml", "rail.toml", "turntable.toml"}) {
        const Scene scene = read_scene(example_scene(name));
        SimulatedScanner scanner(scene, 1);
        const bool swept = scene.channel.axis.kind == MachineKind::swept;
        const std::vector<double> s = {-0.05, 0.0, 0.1, 0.15};
        const RangeImage truth = swept ? scanner.true_range() : scanner.true_range(s);
        double worst = 0;
        std::size_t points = 0;
        for (int v = 0; v < truth.height; ++v)
            for (int k = 0; k < truth.width; k += swept ? 11 : 1) {
                if (!truth.has(k, v)) continue;
                const RangePoint& point = truth.at(k, v);
                const double at = swept ? point.s : s[static_cast<std::size_t>(k)];
                const Rigid3 head = scan_from_camera(scene.channel, at);
                const auto pixel =
                    swept ? std::optional<Eigen::Vector2d>(Eigen::Vector2d(k, v))
                          : project(scene.channel.camera, head.inverse() * point.position);
                ASSERT_TRUE(pixel);
                const auto again = triangulate(scene.channel, *pixel, at);
                ASSERT_TRUE(again);
                const double range = (point.position - head.translation).norm();
                worst = std::max(worst, (again->point_in_scan - point.position).norm() / range);
                ++points;
            }
        EXPECT_GT(points, 200u) << name;
        EXPECT_LT(worst, 1e-6) << name;
    }
}

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "host/geometry/parallel.h"
#include "sim/lens.h"
#include "sim/pixel_pattern.h"
#include "sim/sensor.h"
#include "tests/sim/plate_scene.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

/// A plate square to a small camera 400 mm away, 16 bits without noise, even ambient light.
Scene even_scene() {
    Scene scene = built_in_scene();
    scene.channel.camera = test::pinhole(96, 64, 290);
    scene.sensor.bits = 16;
    scene.sensor.gain_e_per_dn = 0.25;
    scene.sensor.full_well_e = 16000;
    scene.sensor.black_dn = 100;
    scene.sensor.noise = false;
    scene.ambient_level = 0.3;
    scene.objects = {test::plate(400)};
    return scene;
}

double light_of(const Frame& frame, const Scene& scene) {
    double sum = 0;
    for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x) sum += frame.sample(x, y) - scene.sensor.black_dn;
    return sum;
}

// Lindeberg 1990: the discrete Gaussian's sum is 1, its variance t; two in a row are one of the
// variances' sum.
TEST(Lens, DiscreteGaussianHasTheVarianceItIsNamedBy) {
    for (double sigma : {0.05, 0.3, 0.5, 1.0, 2.7, 8.0, 16.0}) {
        const std::vector<float> k = discrete_gaussian(sigma);
        double sum = 0, variance = 0;
        for (std::size_t n = 0; n < k.size(); ++n) {
            const double both = (n > 0 ? 2 : 1) * static_cast<double>(k[n]);
            sum += both;
            variance += both * static_cast<double>(n * n);
        }
        EXPECT_NEAR(sum, 1, 2e-6) << sigma;  // float weights
        EXPECT_NEAR(variance / (sigma * sigma), 1, 1e-4) << sigma;
        if (sigma > 8) continue;  // exp(-t) leaves double's range
        EXPECT_NEAR(k[0], std::exp(-sigma * sigma) * std::cyl_bessel_i(0, sigma * sigma), 1e-6);
    }
    EXPECT_EQ(discrete_gaussian(0).size(), 1u);
}

TEST(Lens, DefocusIsTheThinLensesCircleOfConfusion) {
    Scene scene = even_scene();
    scene.lens.focus_mm = 400;
    scene.sensor.f_number = 4;
    // By Newton's lens equation: images of z and of the focus plane lie v and v0 behind the lens,
    // and the cone of the aperture f / N is cut at v0.
    const double pixel_mm = scene.sensor.pixel_um * 1e-3, f = 290 * pixel_mm;
    const auto behind = [&](double z) { return 1 / (1 / f - 1 / z); };
    for (double z : {100.0, 300.0, 399.0, 400.0, 500.0, 2000.0}) {
        const double disc_mm = f / 4 * std::abs(behind(z) - behind(400)) / behind(z);
        EXPECT_NEAR(spot_sigma_px(scene, z), disc_mm / pixel_mm / 4, 1e-9) << z;
    }
    scene.lens.psf_sigma_px = 0.7;
    EXPECT_NEAR(spot_sigma_px(scene, 400), 0.7, 1e-12);
}

TEST(Lens, ThePictureOfAPointHasTheSpotsWidthAndAllItsLight) {
    const SpotSpread spread;
    constexpr int kWidth = 40, kHeight = 33;
    for (double sigma : {0.25, 0.5, 1.5, 3.0}) {
        std::vector<float> light(kWidth * kHeight, 0.0F), out(light.size(), 0.0F);
        const std::vector<std::uint16_t> spots(light.size(), SpotSpread::index_of(sigma));
        light[16 * kWidth + 20] = 5000;
        spread.gather(light, spots, kWidth, kHeight, 0, kHeight, out);
        double sum = 0, x = 0, xx = 0;
        for (int j = 0; j < kHeight; ++j)
            for (int i = 0; i < kWidth; ++i) {
                const double e = static_cast<double>(out[static_cast<std::size_t>(j * kWidth + i)]);
                sum += e;
                x += e * (i - 20);
                xx += e * (i - 20) * (i - 20);
            }
        EXPECT_NEAR(sum / 5000, 1, 1e-5) << sigma;  // float sums
        EXPECT_NEAR(x / sum, 0, 1e-5);
        EXPECT_NEAR(std::sqrt(xx / sum), sigma, 1e-3);
        // The same rows when cut into bands.
        std::vector<float> band(5 * kWidth, 0.0F);
        spread.gather(light, spots, kWidth, kHeight, 13, 18, band);
        EXPECT_TRUE(std::equal(band.begin(), band.end(), out.begin() + 13 * kWidth));
    }
}

TEST(Lens, AnEvenFieldStaysEvenAndAStripeKeepsItsLight) {
    Scene scene = even_scene();
    const auto pictures = [&](float power) {
        SimulatedScanner scanner(scene, 1);
        return record_still(scanner, 0, power);
    };
    const Frame sharp = pictures(0), sharp_lit = pictures(0.1F);
    scene.lens.psf_sigma_px = 1.3;
    const Frame soft = pictures(0), soft_lit = pictures(0.1F);
    for (int y = 0; y < sharp.height; ++y)
        for (int x = 0; x < sharp.width; ++x)
            ASSERT_NEAR(soft.sample(x, y), sharp.sample(x, y), 1) << x << " " << y;
    const double stripe = light_of(sharp_lit, scene) - light_of(sharp, scene);
    ASSERT_GT(stripe, 1e5);
    // Rounding of 6144 pixels: 0.3 DN each, 23 DN in all; float sums 1e-5.
    EXPECT_NEAR(light_of(soft_lit, scene) - light_of(soft, scene), stripe, 100 + 2e-5 * stripe);
}

// The footprint: stripe and lens add in variance.
TEST(Lens, AStripesWidthGrowsByTheSpotsVariance) {
    Scene scene = even_scene();
    scene.ambient_level = 0;
    scene.channel.sheet.waist_sigma_mm = 1.5;
    const auto variance = [&](float power) {
        SimulatedScanner scanner(scene, 1);
        const Frame frame = record_still(scanner, 0, power);
        double sum = 0, x = 0, xx = 0;
        for (int i = 0; i < frame.width; ++i) {
            const double dn = frame.sample(i, 32) - scene.sensor.black_dn;
            sum += dn;
            x += dn * i;
            xx += dn * i * i;
        }
        return xx / sum - (x / sum) * (x / sum);
    };
    const double sharp = variance(0.1F);
    for (double sigma : {0.5, 1.0, 2.0}) {
        scene.lens.psf_sigma_px = sigma;
        scene.lens.focus_mm = 0;
        EXPECT_NEAR(variance(0.1F) - sharp, sigma * sigma, 0.02 * sigma * sigma) << sigma;
    }
    scene.lens.psf_sigma_px = 0;
    scene.lens.focus_mm = 200;
    scene.sensor.f_number = 1.4;
    scene.sensor.pixel_um = 30;  // a lens of 8.7 mm
    const double spot = spot_sigma_px(scene, 400);
    ASSERT_GT(spot, 1);
    EXPECT_NEAR(variance(1e-4F) - sharp, spot * spot,
                0.03 * spot * spot + 0.02 * spot);  // 1/64 px steps
}

TEST(Lens, VignettingIsCosFourAndTheStatedLossInTheCorner) {
    Scene scene = even_scene();
    SimulatedScanner plain(scene, 1);
    const Frame even = record_still(plain, 0, 0);
    scene.lens.cos4 = true;
    scene.lens.corner_loss = 0.3;
    SimulatedScanner dark_corners(scene, 1);
    const Frame frame = record_still(dark_corners, 0, 0);
    const CameraModel& camera = scene.channel.camera;
    for (const auto& [x, y] : {std::pair{0, 0}, {95, 63}, {47, 31}, {10, 50}}) {
        const double r = std::hypot(x - camera.cx, y - camera.cy);
        const double angle = std::atan(r / camera.fx);
        const double loss = 0.3 * std::pow(r / std::hypot(47.5, 31.5), 2);
        EXPECT_NEAR(frame.sample(x, y) - 100,
                    (even.sample(x, y) - 100) * std::pow(std::cos(angle), 4) * (1 - loss), 1.5)
            << x << " " << y;
    }
}

TEST(Ambient, FlickerIsTheIntegralOverTheExposure) {
    Scene scene = even_scene();
    scene.flicker = {.hz = 120, .depth = 0.6};
    for (double exposure_us : {500.0, 4000.0, 1e6 / 120, 12000.0}) {
        SimulatedScanner scanner(scene, 1);
        Devices d = scanner.devices();
        const auto exposure = static_cast<TimeNs>(exposure_us * 1000);
        ASSERT_TRUE(d.camera.configure({exposure, exposure + 3700 * kNsPerUs}));
        ASSERT_TRUE(d.camera.start());
        Frame frame;
        const double steady_e = full_scale_e(scene.sensor) * 0.3 * 0.8 * exposure_us / 1000;
        for (int k = 0; k < 12; ++k) {
            ASSERT_TRUE(d.camera.next_frame(frame, 10 * kNsPerSecond));
            const double delay = scene.channel.axis.delay_ns;
            const double t0 =
                1e-9 * (static_cast<double>(frame.exposure_start_ns) + std::round(delay));
            double mean = 0;  // of 1 + m cos by the midpoint rule
            constexpr int kSteps = 2000;
            for (int i = 0; i < kSteps; ++i)
                mean += (1 + 0.6 * std::cos(2 * M_PI * 120 *
                                            (t0 + 1e-6 * exposure_us * (i + 0.5) / kSteps))) /
                        kSteps;
            const double expected_e = steady_e / 0.8 * scene.objects[0].albedo * mean;
            if (expected_e > 15000) continue;  // beyond the full well
            EXPECT_NEAR((frame.sample(40, 30) - 100) * 0.25, expected_e, 0.3 + 1e-4 * expected_e)
                << exposure_us << " us, frame " << k;
        }
    }
}

TEST(Ambient, FlickerBandsFollowTheRollingShutter) {
    Scene scene = even_scene();
    scene.flicker = {.hz = 100, .depth = 0.5};
    scene.sensor.row_time_us = 150;
    scene.sensor.exposure_us = 1000;
    scene.sensor.min_frame_period_us = 20000;
    SimulatedScanner scanner(scene, 1);
    const Frame frame = record_still(scanner, 0, 0);
    const double t0 = 1e-9 * (static_cast<double>(frame.exposure_start_ns) +
                              std::round(scene.channel.axis.delay_ns));
    const double part = std::sin(M_PI * 0.1) / (M_PI * 0.1);
    for (int y : {0, 13, 31, 63}) {
        const double middle = t0 + 5e-4 + y * 150e-6;
        const double level = 1 + 0.5 * part * std::cos(2 * M_PI * 100 * middle);
        const double steady = full_scale_e(scene.sensor) * 0.3 * scene.objects[0].albedo;
        EXPECT_NEAR((frame.sample(40, y) - 100) * 0.25, steady * level, 1) << y;
    }
}

TEST(PixelPattern, SensitivityAndOffsetsSpreadAsStatedAndStay) {
    Scene scene = even_scene();
    scene.sensor.prnu = 0.01;
    scene.sensor.dsnu_e = 20;
    const PixelPattern pattern = pixel_pattern(scene, 5);
    double gain = 0, gain2 = 0, offset2 = 0;
    const double n = static_cast<double>(pattern.gain.size());
    for (std::size_t i = 0; i < pattern.gain.size(); ++i) {
        const double g = static_cast<double>(pattern.gain[i]) - 1;
        gain += g / n;
        gain2 += g * g / n;
        offset2 += std::pow(static_cast<double>(pattern.offset_e[i]), 2) / n;
    }
    EXPECT_NEAR(gain, 0, 4 * 0.01 / std::sqrt(n));
    EXPECT_NEAR(std::sqrt(gain2), 0.01, 0.01 * 4 / std::sqrt(2 * n));
    EXPECT_NEAR(std::sqrt(offset2), 20, 20 * 4 / std::sqrt(2 * n));

    SimulatedScanner scanner(scene, 5);
    const Frame one = record_still(scanner, 0, 0), two = record_still(scanner, 0.05, 0);
    EXPECT_EQ(one.bytes, two.bytes);
    SimulatedScanner other(scene, 6);
    EXPECT_NE(one.bytes, record_still(other, 0, 0).bytes);
    // Both in the picture: mean signal S, variance (prnu S)^2 + dsnu^2.
    double sum = 0, squares = 0;
    for (int y = 0; y < one.height; ++y)
        for (int x = 0; x < one.width; ++x) {
            const double e = (one.sample(x, y) - 100) * 0.25;
            sum += e / n;
            squares += e * e / n;
        }
    const double steady = full_scale_e(scene.sensor) * 0.3 * scene.objects[0].albedo;
    EXPECT_NEAR(sum / steady, 1, 1e-3);
    const double spread = std::hypot(0.01 * steady, 20.0);
    EXPECT_NEAR(std::sqrt(squares - sum * sum), spread, spread * 4 / std::sqrt(2 * n));
}

TEST(Sensor, DarkCurrentGrowsWithTheExposureAndIsShotNoise) {
    Scene scene = even_scene();
    scene.ambient_level = 0;
    scene.sensor.noise = true;
    scene.sensor.read_noise_e = 0;
    scene.sensor.dark_current_e_per_s = 50000;
    SimulatedScanner scanner(scene, 1);
    for (double exposure_us : {4000.0, 40000.0}) {
        const Frame frame = record_still(scanner, 0, 0, exposure_us);
        const double expected = 0.05 * exposure_us, n = 96 * 64;
        double sum = 0, squares = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 96; ++x) {
                const double e = (frame.sample(x, y) - 100) * 0.25;
                sum += e / n;
                squares += e * e / n;
            }
        EXPECT_NEAR(sum, expected, 4 * std::sqrt(expected / n));
        EXPECT_NEAR((squares - sum * sum) / expected, 1, 4 * std::sqrt(2 / n));
    }
}

TEST(Sensor, GammaBendsTheResponseBetweenBlackAndTop) {
    SceneSensor sensor;
    sensor.noise = false;
    sensor.black_dn = 10;
    sensor.gain_e_per_dn = 40;
    sensor.gamma = 0.45;
    const std::vector<float> light = {0, 10, 400, 2450, 4900, 9800, 20000};
    std::vector<std::uint8_t> dn(light.size());
    digitise(sensor, noise_key(1, 0, 0), 0, light, dn.data());
    for (std::size_t i = 0; i < light.size(); ++i) {
        const double linear = std::min(static_cast<double>(light[i]), 9800.0) / 40 / 245;
        EXPECT_NEAR(dn[i], 10 + 245 * std::pow(linear, 0.45), 0.6) << light[i];
    }
}

// Offsets come before the converter clips: a pixel of negative offset is as dark as it should be.
TEST(Sensor, OffsetsAndNoiseBelowBlackAreNotCutOffEarly) {
    SceneSensor sensor;
    sensor.bits = 12;
    sensor.gain_e_per_dn = 1;
    sensor.read_noise_e = 20;
    sensor.black_dn = 5;
    const std::vector<float> light(20000, 0.0F), offset(20000, 100.0F);
    std::vector<std::uint8_t> bytes(40000);
    digitise(sensor, noise_key(1, 0, 0), 0, light, bytes.data(), offset);
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
        std::uint16_t dn = 0;
        std::memcpy(&dn, &bytes[2 * i], 2);
        sum += dn / 20000.0;
        squares += dn * dn / 20000.0;
    }
    EXPECT_NEAR(sum, 105, 4 * 20 / std::sqrt(20000.0));
    EXPECT_NEAR(std::sqrt(squares - sum * sum), 20, 0.5);
}

TEST(Faults, DuplicatedFramesComeTwiceUnchanged) {
    Scene scene = even_scene();
    scene.fault.duplicate_frame_probability = 0.2;
    SimulatedScanner scanner(scene, 1);
    Devices d = scanner.devices();
    ASSERT_TRUE(d.camera.start());
    Frame last, frame;
    int repeated = 0;
    constexpr int kFrames = 600;
    for (int i = 0; i < kFrames; ++i) {
        ASSERT_TRUE(d.camera.next_frame(frame, d.clock.now() + kNsPerSecond));
        if (i > 0 && frame.sequence == last.sequence) {
            ++repeated;
            EXPECT_EQ(frame.bytes, last.bytes);
            EXPECT_EQ(frame.exposure_start_ns, last.exposure_start_ns);
        } else if (i > 0) {
            EXPECT_EQ(frame.sequence, last.sequence + 1);
        }
        last = frame;
    }
    // 500 of their own, each twice with 0.2: 100 +- 4 x 9.
    EXPECT_NEAR(repeated, kFrames / 6, 36);
}

// The log says where the axis should be; truth lags and swings about it, and the picture shows it.
TEST(Axis, LagAndPeriodicErrorStayOutOfTheLog) {
    Scene scene = read_scene(example_scene("rail.toml"));
    scene.axis.sigma = 0;
    scene.axis.periodic_error = 0.05;
    scene.axis.periodic_length = 2;
    scene.axis.lag_us = 700;
    scene.channel.axis.delay_ns = 0;
    ASSERT_EQ(validate(scene), "");
    SimulatedScanner scanner(scene, 1);
    Devices d = scanner.devices();
    const double speed = scene.axis.max_speed / 2;
    ASSERT_TRUE(d.axis.move_to(-5, 1000 * kNsPerSecond));
    (void)d.axis.take_log();
    ASSERT_TRUE(d.axis.start_sweep(-5, 5, speed));
    while (d.axis.is_moving()) d.clock.sleep_until(d.clock.now() + kNsPerMs);
    const AxisLog log = d.axis.take_log();
    int compared = 0;
    for (const AxisSample& sample : log.samples) {
        if (std::abs(sample.s) > 4.5) continue;
        const double late = sample.s - speed * 700e-6;
        EXPECT_NEAR(scanner.true_axis_position(sample.t_ns),
                    late + 0.05 * std::sin(2 * M_PI * late / 2), 1e-6);  // mm: ns rounding
        ++compared;
    }
    EXPECT_GT(compared, 20);
    // At rest at s the picture is the one of a true machine at s + error(s).
    Scene exact = scene;
    exact.axis.periodic_error = 0;
    scene.sensor.noise = exact.sensor.noise = false;
    SimulatedScanner a(scene, 1), b(exact, 1), c(exact, 1);
    const auto still = [](SimulatedScanner& scanner_at, double s) {
        Devices at = scanner_at.devices();
        (void)at.axis.move_to(s, 1000 * kNsPerSecond);
        at.clock.sleep_until(at.clock.now() + kNsPerMs);  // past the lag
        return record_still(scanner_at, s, 1).bytes;
    };
    const std::vector<std::uint8_t> shown = still(a, 0.5);
    EXPECT_EQ(shown, still(b, 0.55));
    EXPECT_NE(shown, still(c, 0.5));
}

TEST(Determinism, EffectsTooWhateverTheThreads) {
    for (const char* name : {"swept.toml", "rail.toml"}) {
        Scene scene = read_scene(example_scene(name));
        scene.lens = {.psf_sigma_px = 0.6, .focus_mm = 380, .cos4 = true, .corner_loss = 0.2};
        scene.sensor.prnu = 0.01;
        scene.sensor.dsnu_e = 3;
        scene.sensor.gamma = 0.8;
        scene.flicker.depth = 0.3;
        const auto picture = [&](int threads) {
            set_thread_count(threads);
            SimulatedScanner scanner(scene, 1);
            std::vector<std::uint8_t> bytes = record_still(scanner, 0, 1).bytes;
            set_thread_count(0);
            return bytes;
        };
        const std::vector<std::uint8_t> one = picture(1);
        EXPECT_EQ(one, picture(2)) << name;
        EXPECT_EQ(one, picture(3)) << name;
    }
}

TEST(Scene, EffectsOutsideTheirRangeAreRefusedByName) {
    const auto complaint = [](auto&& change) {
        Scene scene = built_in_scene();
        change(scene);
        return validate(scene);
    };
    const auto names = [](const std::string& why, const char* field) {
        return why.find(field) != std::string::npos && why.find("expected") != std::string::npos;
    };
    EXPECT_TRUE(names(complaint([](Scene& s) { s.sensor.prnu = 0.2; }), "sensor.prnu"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.sensor.dsnu_e = -1; }), "sensor.dsnu_e"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.sensor.dark_current_e_per_s = std::nan(""); }),
                      "sensor.dark_current_e_per_s"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.sensor.gamma = 0; }), "sensor.gamma"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.lens.psf_sigma_px = 9; }), "lens.psf_sigma_px"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.lens.focus_mm = 3; }), "lens.focus_mm"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.lens.corner_loss = 1; }), "lens.corner_loss"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.flicker.hz = 0; }), "ambient.flicker_hz"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.flicker.depth = 1.5; }), "ambient.flicker_depth"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.axis.lag_us = -1; }), "axis.lag_us"));
    EXPECT_TRUE(
        names(complaint([](Scene& s) { s.axis.periodic_error = 0.1; }), "axis.periodic_length"));
    EXPECT_TRUE(names(complaint([](Scene& s) { s.fault.duplicate_frame_probability = 2; }),
                      "fault.duplicate_frame_probability"));
}

TEST(Scene, EffectsAreWrittenAndReadBack) {
    Scene scene = built_in_scene();
    scene.lens = {.psf_sigma_px = 0.6, .focus_mm = 380, .cos4 = true, .corner_loss = 0.2};
    scene.sensor.prnu = 0.01;
    scene.sensor.dsnu_e = 3;
    scene.sensor.dark_current_e_per_s = 20;
    scene.sensor.gamma = 0.45;
    scene.flicker = {.hz = 120, .depth = 0.3};
    scene.fault.duplicate_frame_probability = 0.01;
    scene.axis.lag_us = 120;
    scene.axis.periodic_error = 1e-4;
    const Scene again = parse_scene(format_scene(scene), "effects", "");
    EXPECT_EQ(format_scene(again), format_scene(scene));
    EXPECT_EQ(again.lens.psf_sigma_px, 0.6);
    EXPECT_TRUE(again.lens.cos4);
    EXPECT_EQ(again.flicker.hz, 120);
    EXPECT_EQ(again.sensor.gamma, 0.45);
    EXPECT_EQ(again.fault.duplicate_frame_probability, 0.01);
}

}  // namespace
}  // namespace stria

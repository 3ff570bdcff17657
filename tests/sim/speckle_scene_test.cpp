#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/core/errors.h"
#include "host/geometry/parallel.h"
#include "sim/random.h"
#include "sim/screen_speckle.h"
#include "sim/surface_speckle.h"
#include "tests/sim/plate_scene.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

/// A plate square to a small camera 400 mm away, 16 bits without noise; the laser's line is wide.
Scene plate_scene() {
    Scene scene = built_in_scene();
    scene.channel.camera = test::pinhole(128, 96, 1150);
    scene.sensor.bits = 16;
    scene.sensor.gain_e_per_dn = 0.016;
    scene.sensor.full_well_e = 1040;
    scene.sensor.black_dn = 100;
    scene.sensor.noise = false;
    scene.ambient_level = 0;
    scene.channel.sheet.waist_sigma_mm = 4;
    scene.channel.sheet.bow2 = scene.channel.sheet.bow3 = 0;
    SceneObject plate = test::plate(400);
    plate.world_from_object = {rotation_from_vector({0, 0, 0.3}), {3, 2, -400}};
    scene.objects = {plate};
    return scene;
}

constexpr unsigned kSeed = 7;

std::uint64_t machine_seed(const Scene& scene) { return counter_random::mix64(scene.seed) ^ kSeed; }

/// Where pixel (u, v) looks at the plate at s, object frame.
Eigen::Vector3d seen_at(const Scene& scene, double u, double v, double s) {
    const Rigid3 world_from_camera = scan_from_camera(scene.channel, s);
    const Rigid3 object_from_world = scene.objects[0].world_from_object.inverse();
    const Eigen::Vector3d eye = object_from_world * world_from_camera.translation;
    const Eigen::Vector3d ray = object_from_world.rotation * world_from_camera.rotation *
                                ray_through(scene.channel.camera, {u, v});
    return eye - eye.z() / ray.z() * ray;
}

/// DN above black of a frame with the axis at rest, and the pixels' ratio to another's.
Frame picture(const Scene& scene, double s, float power = 0.2F) {
    SimulatedScanner scanner(scene, kSeed);
    return record_still(scanner, s, power);
}

TEST(SurfaceSpeckle, IsGammaDistributedWithItsContrast) {
    for (const double contrast : {1.0, 0.5, 0.1}) {
        const SurfaceSpeckle speckle(
            {.model = SpeckleModel::surface, .contrast = contrast, .length_mm = 0.2}, 3);
        constexpr int kPoints = 40000;  // on a lattice too wide to correlate
        double sum = 0, square = 0, third = 0;
        for (int i = 0; i < kPoints; ++i) {
            const double f = speckle.at(0, {1.37 * (i % 200), 1.91 * (i / 200), 0.73 * (i % 7)});
            ASSERT_GE(f, 0);
            sum += f;
            square += (f - 1) * (f - 1);
            third += std::pow(f - 1, 3);
        }
        EXPECT_NEAR(sum / kPoints, 1, 5 * contrast / std::sqrt(kPoints)) << contrast;
        EXPECT_NEAR(std::sqrt(square / kPoints), contrast, 0.03 * contrast);
        // A gamma distribution's third central moment is 2 C^4.
        EXPECT_NEAR(third / kPoints, 2 * std::pow(contrast, 4), 0.25 * std::pow(contrast, 3));
    }
}

TEST(SurfaceSpeckle, CorrelatesOverItsLengthInEveryDirection) {
    const double contrast = 0.6, length = 0.3;
    const SurfaceSpeckle speckle(
        {.model = SpeckleModel::surface, .contrast = contrast, .length_mm = length}, 4);
    for (const Eigen::Vector3d& way :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0.6, 0.8), Eigen::Vector3d(1, 1, 1)}) {
        const Eigen::Vector3d step = way.normalized() * length / 8;
        double area = 0;  // of the covariance over contrast^2, by segments of many lines
        constexpr int kLines = 10000, kSteps = 20;
        for (int line = 0; line < kLines; ++line) {
            const Eigen::Vector3d from(2.1 * (line % 37), 1.7 * (line % 31), 1.3 * line);
            const double here = speckle.at(1, from) - 1;
            for (int k = -kSteps; k <= kSteps; ++k)
                area += here * (speckle.at(1, from + k * step) - 1) * length / 8;
        }
        EXPECT_NEAR(area / (kLines * contrast * contrast), length,
                    0.1 * length)  // chance: 2 to 3 %
            << way.transpose();
    }
}

TEST(SurfaceSpeckle, SticksToTheObjectWhereverTheAxisIs) {
    Scene scene = plate_scene();
    scene.channel.axis.kind = MachineKind::rail;
    scene.channel.axis.rail.direction = Eigen::Vector3d::UnitX();
    scene.channel.sheet.apex = {60, 0, -20};
    scene.channel.sheet.central_ray = Eigen::Vector3d(-60, 0, 420).normalized();
    scene.channel.sheet.normal = Eigen::Vector3d(420, 0, 60).normalized();
    scene.channel.sheet.offset_mm = scene.channel.sheet.normal.dot(scene.channel.sheet.apex);
    scene.channel.sheet = normalised(scene.channel.sheet);
    scene.axis = {.min = -20, .max = 20, .max_speed = 50, .sigma = 0, .log_period_us = 500};
    for (const MachineKind kind : {MachineKind::rail, MachineKind::swept}) {
        Scene plain = kind == MachineKind::rail ? scene : plate_scene();
        Scene grainy = plain;
        grainy.speckle = {.model = SpeckleModel::surface, .contrast = 0.4, .length_mm = 2.0};
        const SurfaceSpeckle speckle(grainy.speckle, machine_seed(grainy));
        for (const double s : {0.0, kind == MachineKind::rail ? 3.7 : 0.01}) {
            const Frame with = picture(grainy, s), without = picture(plain, s);
            int compared = 0;
            for (int v = 4; v < 92; v += 3)
                for (int u = 4; u < 124; u += 3) {
                    const double light = without.sample(u, v) - 100;
                    if (light < 2000 || light > 20000) continue;
                    ++compared;
                    // 0.35 mm a pixel: the factor bends by 1 % within it, 16 bits add nothing.
                    EXPECT_NEAR((with.sample(u, v) - 100) / light,
                                speckle.at(0, seen_at(plain, u, v, s)), 0.03)
                        << u << ", " << v << " at " << s;
                }
            EXPECT_GT(compared, 300);
        }
    }
}

// A pixel's light leans to the brighter side of what it sees, and so does its pulse: by the slope
// of the pattern, which is what a footprint costs spacetime analysis.
TEST(SurfaceSpeckle, MovesAPulseByWhatThePixelSees) {
    Scene scene = plate_scene();
    scene.speckle = {.model = SpeckleModel::surface, .contrast = 0.5, .length_mm = 1.5};
    const SurfaceSpeckle speckle(scene.speckle, machine_seed(scene));
    const Scene plain = plate_scene();
    SimulatedScanner with(scene, kSeed), without(plain, kSeed);
    // Mean axis position of a pixel's light over all of the passage, in pixels of the stripe's way.
    const auto centres = [](SimulatedScanner& scanner) {
        const SimSweep sweep = record_sweep(scanner, -0.12, 0.06, 0.002, 0.2F);
        std::vector<double> light(128 * 96), first(light.size());
        for (std::size_t k = 0; k < sweep.frames.size(); ++k)
            for (int v = 0; v < 96; ++v)
                for (int u = 0; u < 128; ++u) {
                    const std::size_t i = static_cast<std::size_t>(v * 128 + u);
                    const double dn = sweep.frames[k].sample(u, v) - 100;
                    light[i] += dn;
                    first[i] += dn * sweep.s[k];
                }
        for (std::size_t i = 0; i < light.size(); ++i) first[i] /= light[i];
        return first;
    };
    const std::vector<double> grainy = centres(with), even = centres(without);
    double found = 0, expected = 0, both = 0;
    for (int v = 10; v < 86; v += 2)
        for (int u = 40; u < 88; u += 2) {
            const std::size_t i = static_cast<std::size_t>(v * 128 + u);
            const double s_per_px = (even[i + 1] - even[i - 1]) / 2;
            double sum = 0, lean = 0;  // over the pixel, by 11 x 11 points
            for (int a = -5; a <= 5; ++a)
                for (int b = -5; b <= 5; ++b) {
                    const double f = speckle.at(0, seen_at(scene, u + a / 11.0, v + b / 11.0, 0));
                    sum += f;
                    lean += f * a / 11.0;
                }
            const double shift = (grainy[i] - even[i]) / s_per_px, truth = lean / sum;
            found += shift * shift;
            expected += truth * truth;
            both += shift * truth;
        }
    EXPECT_GT(std::sqrt(expected / (38 * 24)), 0.005);  // px: it is there to be found
    EXPECT_NEAR(both / expected, 1, 0.1);
    EXPECT_GT(both / std::sqrt(found * expected), 0.97);
}

TEST(ScreenSpeckle, HasTheContrastThatThePixelLeaves) {
    Scene scene = plate_scene();
    scene.channel.camera.width = 256;
    scene.channel.camera.height = 256;
    for (const double f_number : {8.0, 16.0}) {
        for (const double contrast : {1.0, std::sqrt(0.5)}) {
            scene.sensor.f_number = f_number;
            scene.speckle = {.model = SpeckleModel::screen, .contrast = contrast};
            const double rho_px = 650e-3 * f_number / scene.sensor.pixel_um;
            EXPECT_DOUBLE_EQ(speckle_px(scene), rho_px);
            const std::vector<float> gain = screen_speckle(scene, 5);
            double sum = 0, square = 0, beside = 0;
            for (std::size_t i = 0; i + 1 < gain.size(); ++i) {
                const double g = static_cast<double>(gain[i]) - 1;
                sum += g;
                square += g * g;
                if (i % 128 < 127) beside += g * (static_cast<double>(gain[i + 1]) - 1);
            }
            const auto n = static_cast<double>(gain.size());
            // Covariance of pixels 0 and 1 px apart: the pixels' overlap times |2 J1(v) / v|^2.
            const auto covariance = [&](double lag) {
                constexpr int kNodes = 80;
                double total = 0;
                for (int i = 0; i < kNodes; ++i)
                    for (int j = 0; j < kNodes; ++j) {
                        const double x = 2 * (i + 0.5) / kNodes - 1, y = 2 * (j + 0.5) / kNodes - 1;
                        const double v = std::numbers::pi * std::hypot(x + lag, y) / rho_px;
                        const double airy = v < 1e-9 ? 1 : 2 * std::cyl_bessel_j(1.0, v) / v;
                        total += (1 - std::abs(x)) * (1 - std::abs(y)) * airy * airy;
                    }
                return total * 4 / (kNodes * kNodes) * contrast * contrast;
            };
            EXPECT_NEAR(sum / n, 0, 0.02);
            EXPECT_NEAR(std::sqrt(square / n), std::sqrt(covariance(0)),
                        0.05 * std::sqrt(covariance(0)))
                << f_number << ", " << contrast;
            EXPECT_NEAR(beside / (n * 127 / 128), covariance(1), 0.05 * covariance(0));
        }
    }
}

TEST(ScreenSpeckle, StaysInTheImageAndLeavesAmbientLightAlone) {
    Scene plain = plate_scene();
    plain.ambient_level = 0.1;
    Scene grainy = plain;
    grainy.speckle = {.model = SpeckleModel::screen, .contrast = 1};
    const std::vector<float> gain = screen_speckle(grainy, machine_seed(grainy));
    EXPECT_EQ(picture(grainy, 0, 0).bytes, picture(plain, 0, 0).bytes);
    for (const double psf_px : {0.0, 0.8})
        for (const double s : {0.0, 0.01}) {
            grainy.lens.psf_sigma_px = plain.lens.psf_sigma_px = psf_px;
            const Frame with = picture(grainy, s), without = picture(plain, s);
            const Frame dark = picture(plain, s, 0);
            for (int v = 0; v < 96; v += 5)
                for (int u = 0; u < 128; u += 5) {
                    const double light = without.sample(u, v) - dark.sample(u, v);
                    const std::size_t i = static_cast<std::size_t>(v * 128 + u);
                    EXPECT_NEAR(with.sample(u, v) - dark.sample(u, v),
                                light * static_cast<double>(gain[i]),
                                3 + 1e-3 * light);  // rounding
                }
        }
}

TEST(SceneSpeckle, GivesTheSameBytesOnAnyNumberOfThreads) {
    for (const SpeckleModel model : {SpeckleModel::surface, SpeckleModel::screen}) {
        Scene scene = plate_scene();
        scene.speckle = {.model = model, .contrast = 0.8, .length_mm = 0.5};
        set_thread_count(1);
        const Frame one = picture(scene, 0);
        set_thread_count(3);
        EXPECT_EQ(picture(scene, 0).bytes, one.bytes);
        set_thread_count(0);
    }
}

TEST(SceneSpeckle, IsReadAndWritten) {
    Scene scene = plate_scene();
    scene.speckle = {.model = SpeckleModel::surface, .contrast = 0.37, .length_mm = 0.08};
    const Scene again = parse_scene(format_scene(scene), "scene.toml", "");
    EXPECT_EQ(again.speckle.model, scene.speckle.model);
    EXPECT_EQ(again.speckle.contrast, scene.speckle.contrast);
    EXPECT_EQ(again.speckle.length_mm, scene.speckle.length_mm);
    std::string text = format_scene(scene);
    text.replace(text.find("\"surface\""), 9, "\"grainy\"");
    EXPECT_THROW((void)parse_scene(text, "scene.toml", ""), FileError);
}

TEST(SceneSpeckle, RefusesWhatCannotBe) {
    Scene scene = plate_scene();
    scene.speckle = {.model = SpeckleModel::surface, .contrast = 1.2};
    EXPECT_NE(validate(scene).find("laser.speckle.contrast"), std::string::npos);
    scene.speckle = {.model = SpeckleModel::surface, .contrast = 0.5, .length_mm = 0};
    EXPECT_NE(validate(scene).find("laser.speckle.length_mm"), std::string::npos);
    scene.speckle = {.model = SpeckleModel::screen, .contrast = 0.5};
    EXPECT_NE(validate(scene).find("laser.speckle.contrast"), std::string::npos);
    scene.speckle.contrast = 1;
    EXPECT_EQ(validate(scene), "");
    scene.channel.axis.kind = MachineKind::rail;
    EXPECT_NE(validate(scene).find("screen"), std::string::npos);
}

}  // namespace
}  // namespace stria

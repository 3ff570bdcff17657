#include "sim/beam.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "sim/stripe_light.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

SurfaceHit hit_at(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, float albedo = 1) {
    SurfaceHit hit;
    hit.point = point;
    hit.normal = normal.normalized().cast<float>();
    hit.albedo = albedo;
    hit.object = 0;
    return hit;
}

Scene bowed_scene() {
    Scene scene = built_in_scene();
    scene.channel.sheet.bow2 = 3e-3;
    scene.channel.sheet.bow3 = -2e-3;
    scene.channel.axis.mirror.g2 = 0.03;
    scene.channel.axis.mirror.g3 = 0.1;
    return scene;
}

// Oracle: sheet_at and signed_distance of the scanner model.
TEST(Beam, SweptSheetPassesWhereTheModelSaysSo) {
    const Scene scene = bowed_scene();
    const Beam beam(scene);
    const Rigid3 camera_from_world = scan_from_camera(scene.channel, 0).inverse();
    std::mt19937 rng(5);
    std::uniform_real_distribution<double> side(-60, 60), depth(-460, -340);
    for (int i = 0; i < 300; ++i) {
        const Eigen::Vector3d point(side(rng), side(rng), depth(rng));
        const auto passing = beam.passing(hit_at(point, {0.3, 0, 1}), 0);
        ASSERT_TRUE(passing) << point.transpose();
        const Eigen::Vector3d p = camera_from_world * point;
        const LaserSheet sheet = sheet_at(scene.channel, passing->position);
        EXPECT_NEAR(signed_distance(sheet, p), 0, 1e-9);  // mm: Newton's last step
        const double h = 1e-6;
        const double slope = (signed_distance(sheet_at(scene.channel, passing->position + h), p) -
                              signed_distance(sheet_at(scene.channel, passing->position - h), p)) /
                             (2 * h);
        // The bow's own slope is left out of the width: 1e-3 of it.
        EXPECT_NEAR(std::abs(passing->per_s) * sigma_at(sheet, p), std::abs(slope),
                    2e-3 * std::abs(slope));
        EXPECT_GT(passing->rate, 0);
        // The light comes from a point on the mirror, in the sheet.
        const Eigen::Vector3d source = camera_from_world * passing->light_in_world;
        const Eigen::Vector3d apex_way = (sheet.apex - p).normalized();
        EXPECT_LT(apex_way.cross(source - p).norm(), 1e-6);
    }
}

TEST(Beam, PointsBehindTheMirrorStayDark) {
    const Scene scene = built_in_scene();
    const auto passing = Beam(scene).passing(hit_at({400, 0, 60}, {-1, 0, 0}), 0);
    EXPECT_TRUE(!passing || passing->rate == 0);
}

// Energy: irradiance over a plane across the sheet sums to the laser's power in that part of the
// fan.
TEST(Beam, IrradianceHoldsThePower) {
    Scene scene = read_scene(example_scene("rail.toml"));
    scene.channel.sheet.bow2 = 0;
    const Beam beam(scene);
    const LaserSheet& sheet = scene.channel.sheet;
    const HeadPose head = head_pose(scene.channel, 0);
    const double range_mm = 300;
    const Eigen::Vector3d t = sheet.normal.cross(sheet.central_ray);
    // A white Lambert plane square to the central ray: rate at the sheet's centre times the
    // profile's area, along the fan, must be power x electrons per (mW / mm^2).
    double along = 0;
    const double step = 0.25;
    for (double y = -250; y < 250; y += step) {
        const Eigen::Vector3d p = sheet.apex + range_mm * sheet.central_ray + y * t;
        const BeamAtPoint at =
            beam.beside(hit_at(head.world_from_camera * p, head.world_from_camera.rotation *
                                                               Eigen::Vector3d(-sheet.central_ray)),
                        head);
        along += at.rate * sigma_at(sheet, p) * std::sqrt(2 * M_PI) * step;
    }
    const SceneSensor& sensor = scene.sensor;
    const double pixel = sensor.pixel_um * 1e-6;
    const double electrons = 1e-3 * scene.laser_power_mw * 1e6 * pixel * pixel /
                             (4 * sensor.f_number * sensor.f_number) * sensor.quantum_efficiency *
                             sheet.wavelength_nm * 1e-9 / (6.62607015e-34 * 299792458.0);
    // 1 % of the fan lies in its soft ends.
    EXPECT_NEAR(along / electrons, 0.99, 0.003);
}

TEST(Beam, OrenNayarAgainstItsFormula) {
    const Eigen::Vector3d n(0, 0, 1);
    const auto at = [](double polar, double azimuth) {
        return Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                               std::sin(polar) * std::sin(azimuth), std::cos(polar));
    };
    EXPECT_EQ(oren_nayar(n, at(0.3, 0), at(0.5, 2), 0), 1);
    const double s2 = 0.3 * 0.3, a = 1 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
    EXPECT_NEAR(oren_nayar(n, n, n, 0.3), a, 1e-12);
    EXPECT_NEAR(oren_nayar(n, at(0.8, 0.2), at(0.5, 0.7), 0.3),
                a + b * std::cos(0.5) * std::sin(0.8) * std::tan(0.5), 1e-12);
    EXPECT_NEAR(oren_nayar(n, at(0.8, 0), at(0.5, 3), 0.3), a, 1e-12);  // eye on the far side
}

TEST(StripeLight, MeanOfAGaussianAgainstASum) {
    for (double x0 : {-3.0, -0.7, 0.0, 1.9}) {
        for (double width : {1e-6, 1e-3, 0.049, 0.051, 0.5, 4.0}) {
            double sum = 0;
            constexpr int kSteps = 4000;
            for (int i = 0; i < kSteps; ++i) {
                const double x = x0 + width * (i + 0.5) / kSteps;
                sum += std::exp(-x * x / 2) / kSteps;
            }
            EXPECT_NEAR(mean_gaussian(x0, x0 + width), sum, 1e-7);
            EXPECT_NEAR(mean_gaussian(x0 + width, x0), sum, 1e-7);
        }
    }
}

TEST(StripeLight, BinsChangeNothing) {
    std::mt19937 rng(3);
    std::uniform_real_distribution<double> s(-0.2, 0.2), per(500, 3000);
    LightBlock block;
    block.row_end = 8;
    block.ambient.assign(8 * 100, 0.0F);
    for (std::uint32_t i = 0; i < 4000; ++i)
        block.lights.push_back({s(rng), static_cast<float>(per(rng)), 1000.0F, i % 800});
    const std::vector<StripeLight> all = block.lights;
    sort_into_bins(block);
    for (double at = -0.21; at < 0.21; at += 0.013) {
        const Exposure exposure{at, at + 0.001, 0.002};
        std::vector<float> fast(800, 0.0F), slow(800, 0.0F);
        add_stripe(block, 100, {&exposure, 1}, 0, fast);
        for (const StripeLight& light : all)
            slow[light.pixel] +=
                light.rate *
                static_cast<float>(0.002 * mean_gaussian((at - light.s0) * light.per_s,
                                                         (at + 0.001 - light.s0) * light.per_s));
        for (std::size_t i = 0; i < fast.size(); ++i)
            EXPECT_NEAR(fast[i], slow[i], 1e-6F + 1e-5F * slow[i]);  // 5.5 sigma cut, float sums
    }
}

}  // namespace
}  // namespace stria

#include "sim/light_shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sim/beam.h"
#include "sim/view_light.h"
#include "tests/sim/plate_scene.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

constexpr double kPi = std::numbers::pi;

struct Moments {
    double power = 0, mean = 0, variance = 0;
};

/// Of Gaussians of s, in closed form.
Moments moments_of(std::span<const StripeLight> lights, std::uint32_t pixel) {
    Moments m;
    double square = 0;
    for (const StripeLight& light : lights) {
        if (light.pixel != pixel) continue;
        const double sigma = 1 / static_cast<double>(light.per_s);
        const double power = static_cast<double>(light.rate) * sigma;
        m.power += power;
        m.mean += power * light.s0;
        square += power * (light.s0 * light.s0 + sigma * sigma);
    }
    m.mean /= m.power;
    m.variance = square / m.power - m.mean * m.mean;
    return m;
}

double value_at(std::span<const StripeLight> lights, double s) {
    double sum = 0;
    for (const StripeLight& light : lights) {
        const double x = (s - light.s0) * static_cast<double>(light.per_s);
        sum += static_cast<double>(light.rate) * std::exp(-x * x / 2);
    }
    return sum;
}

/// A translucent plate under the built-in scanner, seen by its middle column of pixels.
Scene translucent_scene(double tilt_rad) {
    Scene scene = built_in_scene();
    scene.channel.sheet.bow2 = 0;
    scene.channel.camera = test::pinhole(33, 33, 1150);
    scene.objects = {test::plate(400)};
    scene.objects[0].world_from_object.rotation = rotation_from_vector({0, tilt_rad, 0});
    return scene;
}

Moments middle_pixel(const Scene& scene) {
    const SceneGeometry geometry(scene);
    const std::vector<LightBlock> blocks = ViewLight(scene, geometry, 1).whole_sweep();
    return moments_of(blocks[0].lights, 16 * 33 + 16);
}

// exp(-r / l) / (2 pi l^2) over a plane, summed along a line: |x| K1(|x| / l) / (pi l^2).
TEST(LightParts, StandForTheKernelOfAnExponentialSpot) {
    Scene scene = translucent_scene(0);
    scene.objects[0].subsurface = 1;
    const LightParts parts(scene);
    for (double spread : {0.5, 1.0, 4.0}) {
        std::vector<StripeLight> lights;
        parts.add({0, 1, 1, 0}, 0, {1, 0, static_cast<float>(spread), 1}, lights);
        const auto kernel = [&](double x) {
            const double r = std::abs(x) / spread;
            return (r < 1e-9 ? 1 : r * std::cyl_bessel_k(1, r)) / (kPi * spread);
        };
        const auto exact = [&](double at) {  // the beam's Gaussian, spread by the kernel
            double sum = 0;
            const double step = 0.02;
            for (double x = -40; x < 40; x += step)
                sum += kernel(x) * std::exp(-(at - x) * (at - x) / 2) * step;
            return sum;
        };
        const double peak = exact(0);
        double worst = 0;
        for (double x = 0; x < 12; x += 0.25)
            worst = std::max(worst, std::abs(value_at(lights, x) - exact(x)) / peak);
        std::printf("free path %.1f beam widths: worst %.4f of the peak\n", spread, worst);
        EXPECT_LT(worst, spread <= 1 ? 0.01 : 0.03) << spread;
        const Moments m = moments_of(lights, 0);
        EXPECT_NEAR(m.power, 1, 1e-6);
        EXPECT_NEAR(m.variance, 1 + 3 * spread * spread, 1e-5 * m.variance);
    }
}

// Light that falls on x - d leaves at x: the pixel's pulse comes when the sheet passes x - d.
TEST(Subsurface, ShiftsAndWidensThePulseAsItsClosedFormSays) {
    for (double tilt : {-0.9, -0.4, 0.0, 0.5}) {
        Scene scene = translucent_scene(tilt);
        const Moments plain = middle_pixel(scene);
        SceneObject& plate = scene.objects[0];
        plate.subsurface = 0.6;
        plate.free_path_mm = 0.3;
        plate.refractive_index = 1.5;
        const Moments found = middle_pixel(scene);

        // The point that the pixel sees, where its light comes from, by vectors.
        const Eigen::Vector3d normal = plate.world_from_object.rotation.col(2), point(0, 0, -400);
        SurfaceHit hit;
        hit.point = point;
        hit.normal = normal.cast<float>();
        hit.albedo = 1;
        hit.object = 0;
        const auto passing = Beam(scene).passing(hit, 0);
        ASSERT_TRUE(passing);
        const Eigen::Vector3d ray = (point - passing->light_in_world).normalized();
        // Snell's law in vector form; the free path's end under the surface.
        const double ci = -normal.dot(ray), n = 1.5;
        const double ct = std::sqrt(1 - (1 - ci * ci) / (n * n));
        const Eigen::Vector3d refracted = ray / n + (ci / n - ct) * normal;
        ASSERT_NEAR(refracted.norm(), 1, 1e-12);
        const Eigen::Vector3d end = 0.3 * refracted;
        const Eigen::Vector3d entry = point - (end - normal.dot(end) * normal);
        const auto passes = [&](const Eigen::Vector3d& p) {
            SurfaceHit other = hit;
            other.point = p;
            return Beam(scene).passing(other, 0)->position;
        };
        const double rs = (ci - n * ct) / (ci + n * ct), rp = (n * ci - ct) / (n * ci + ct);
        const double share = 0.6 * (1 - (rs * rs + rp * rp) / 2);
        const double shift = passes(entry) - passes(point);
        EXPECT_NEAR(found.mean - plain.mean, share * shift, 0.003 * std::abs(shift) + 1e-9)
            << tilt;  // the sheet's place curves by 1e-3 over the shift
        // Along the surface across the line: a free path moves the sheet by `slope`.
        const Eigen::Vector3d along = Eigen::Vector3d::UnitY().cross(normal);
        const double slope = (passes(point + 0.01 * along) - passes(point - 0.01 * along)) / 0.02;
        const double wider =
            share * 3 * std::pow(0.3 * slope, 2) + share * (1 - share) * shift * shift;
        EXPECT_NEAR(found.variance - plain.variance, wider, 0.01 * wider) << tilt;
        EXPECT_NEAR(found.power / plain.power, 1, 1e-4) << tilt;  // no light is lost
    }
}

// Across the sheet the bias is share T(angle) (l / n) sin(angle) cos(angle), angle that of
// incidence: nothing square to the light, most at a tilt between, nothing at grazing.
TEST(Subsurface, BiasIsZeroOnNormalIncidenceGrowsWithTiltAndFallsAtGrazing) {
    const auto bias = [](double degrees) {
        const double c = std::cos(degrees * kPi / 180);
        return fresnel_transmission(c, 1.5) * std::sin(degrees * kPi / 180) * c;
    };
    EXPECT_EQ(bias(0), 0);
    EXPECT_LT(bias(15), bias(30));
    EXPECT_LT(bias(30), bias(40));
    EXPECT_GT(bias(45), bias(70));
    EXPECT_GT(bias(70), 3 * bias(85));
    // The scene's own figures follow it.
    Scene scene = translucent_scene(0);
    scene.objects[0].subsurface = 1;
    scene.objects[0].free_path_mm = 0.3;
    scene.objects[0].refractive_index = 1.5;
    const Beam beam(scene);
    SurfaceHit hit;
    hit.point = {0, 0, -400};
    hit.albedo = 1;
    hit.object = 0;
    hit.normal = {0, 0, 1};
    const Eigen::Vector3d to_light =
        (beam.passing(hit, 0)->light_in_world - hit.point).normalized();
    const double sigma_mm =
        sigma_at(sheet_at(scene.channel, beam.passing(hit, 0)->position), {0, 0, 400});
    for (double degrees : {0.0, 20.0, 45.0, 70.0, 85.0}) {
        const Eigen::AngleAxisd turn(degrees * kPi / 180, Eigen::Vector3d::UnitY());
        hit.normal = (turn * to_light).cast<float>();
        const LightShape shape = beam.passing(hit, 0)->shape;
        EXPECT_NEAR(std::abs(shape.inside * shape.shift), bias(degrees) * 0.3 / 1.5 / sigma_mm,
                    2e-3 / sigma_mm * 0.2)
            << degrees;
    }
}

TEST(Subsurface, WhatTheGlossyLobeThrowsBackDoesNotEnter) {
    Scene scene = translucent_scene(0.2);
    scene.objects[0].subsurface = 0.5;
    SurfaceHit hit;
    hit.point = {0, 0, -400};
    hit.normal = {0, 0, 1};
    hit.albedo = 0.4F;
    hit.object = 0;
    const float matt = Beam(scene).passing(hit, 0)->shape.inside;
    hit.specular = 0.5F;
    hit.gloss = 0.3F;
    const auto glossy = Beam(scene).passing(hit, 0);
    const Eigen::Vector3d to_light = (glossy->light_in_world - hit.point).normalized();
    const double lobe = kPi * 0.5 *
                        glossy_lobe(Eigen::Vector3d::UnitZ(), to_light, Eigen::Vector3d::UnitZ(),
                                    static_cast<double>(hit.gloss));
    EXPECT_NEAR(glossy->shape.inside / matt, 0.4 / (0.4 + lobe), 1e-5);
}

TEST(SheetProfile, ALobeKeepsThePowerAndMovesTheCentroid) {
    Scene scene = translucent_scene(0.1);
    const Moments plain = middle_pixel(scene);
    scene.line.lobe = 0.05;
    scene.line.lobe_shift = 1.5;
    const Moments found = middle_pixel(scene);
    const double share = 2 * 0.05 / (1 + 2 * 0.05);  // of the power: twice as wide
    SurfaceHit hit;
    hit.point = {0, 0, -400};
    hit.normal = {0, 0, 1};
    hit.albedo = 1;
    hit.object = 0;
    const double sigma = 1 / Beam(scene).passing(hit, 0)->per_s;  // of s, no pixel's footprint
    EXPECT_NEAR(found.power / plain.power, 1, 1e-6);
    EXPECT_NEAR(std::abs(found.mean - plain.mean) / sigma, share * 1.5, 2e-3);
    EXPECT_NEAR((found.variance - plain.variance) / (sigma * sigma),
                share * 3 + share * (1 - share) * 2.25, 5e-3);
    // Towards +normal of the laser's sheet: where that distance is 1.5 widths.
    const MirrorAxis& mirror = scene.channel.axis.mirror;
    const auto distance = [&](double s) {
        const double g = s + s * s * (mirror.g2 + s * mirror.g3);
        const Eigen::Vector3d m = Eigen::AngleAxisd(g, mirror.direction) * mirror.normal0;
        const Eigen::Vector3d p(0, 0, 400);
        const double height = m.dot(p - mirror.point) - mirror.offset_mm;
        return signed_distance(scene.channel.sheet, p - 2 * height * m);
    };
    const double grows = distance(plain.mean + 1e-4) - distance(plain.mean);
    EXPECT_GT((found.mean - plain.mean) * grows, 0);
}

TEST(SheetProfile, M2DividesTheRayleighRange) {
    for (const char* name : {"swept.toml", "rail.toml"}) {
        Scene scene = read_scene(example_scene(name));
        scene.line.m2 = 1.7;
        const HeadPose head = head_pose(scene.channel, 0);
        const LaserSheet& sheet = scene.channel.sheet;
        SurfaceHit hit;
        hit.albedo = 1;
        hit.object = 0;
        for (double depth : {250.0, 400.0, 900.0}) {
            hit.point = head.world_from_camera * Eigen::Vector3d(3, -8, depth);
            hit.normal = {0, 0, 1};
            const Beam good(scene);
            Scene ideal = scene;
            ideal.line.m2 = 1;
            const Beam perfect(ideal);
            const bool swept = scene.channel.axis.kind == MachineKind::swept;
            if (swept && !good.passing(hit, 0)) continue;
            const double ratio =
                swept
                    ? perfect.passing(hit, 0)->per_s / good.passing(hit, 0)->per_s
                    : perfect.beside(hit, head).per_position / good.beside(hit, head).per_position;
            // Distance along the light from the width itself: sigma^2 = s0^2 (1 + (z / z_R)^2).
            const double s0 = sheet.waist_sigma_mm;
            const double sigma =
                swept ? sigma_at(sheet_at(scene.channel, perfect.passing(hit, 0)->position),
                                 {3, -8, depth})
                      : sigma_at(sheet, {3, -8, depth});
            const double defocus2 = sigma * sigma / (s0 * s0) - 1;
            EXPECT_NEAR(ratio, std::sqrt((1 + 1.7 * 1.7 * defocus2) / (1 + defocus2)), 1e-9)
                << name << " " << depth;
        }
    }
}

// The first orders: lines that leave the apex under +-ghost_rad, with their share of the power.
TEST(SheetProfile, GhostLinesStandBesideTheLineUnderTheirAngle) {
    Scene scene = translucent_scene(0);
    scene.line.ghost = 0.04;
    scene.line.ghost_rad = 0.03;
    const SceneGeometry geometry(scene);
    const std::vector<LightBlock> blocks = ViewLight(scene, geometry, 1).whole_sweep();
    const Eigen::Vector3d point(0, 0, 400);
    std::array<double, 3> power{};
    for (const StripeLight& light : blocks[0].lights) {
        if (light.pixel != 16 * 33 + 16) continue;
        const LaserSheet sheet = sheet_at(scene.channel, light.s0);
        const Eigen::Vector3d way = point - sheet.apex;
        const double angle = std::atan2(sheet.normal.dot(way), sheet.central_ray.dot(way));
        const long order = std::lround(angle / 0.03);
        ASSERT_LE(std::abs(order), 1);
        // Parts of the pixel's footprint lie beside its centre: a width of the sheet is 5e-4 rad.
        EXPECT_NEAR(angle, 0.03 * static_cast<double>(order), 3e-4);
        power[static_cast<std::size_t>(order + 1)] += static_cast<double>(light.rate / light.per_s);
    }
    // The three come at other mirror angles, so range and incidence differ by a few per cent.
    EXPECT_NEAR(power[0] / power[1], 0.04 / 0.92, 0.05 * 0.04);
    EXPECT_NEAR(power[2] / power[1], 0.04 / 0.92, 0.05 * 0.04);
    scene.line.ghost = 0.25;
    EXPECT_NE(validate(scene).find("laser.ghost = 0.25"), std::string::npos);
}

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "host/core/errors.h"
#include "sim/bounce_light.h"
#include "sim/form_factor.h"
#include "sim/mirror_light.h"
#include "tests/sim/plate_scene.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

constexpr double kPi = std::numbers::pi;

/// A rectangle about `centre`, its sides along x and y.
SceneObject plate(const std::string& name, const Eigen::Vector2d& size, const Eigen::Vector3d& x,
                  const Eigen::Vector3d& y, const Eigen::Vector3d& centre) {
    Eigen::Matrix3d sides;
    sides << x, y, x.cross(y);
    SceneObject object = test::rectangle(name, -size / 2, size, {sides, centre});
    object.albedo = 0.7;
    return object;
}

/// A floor z = -450 under the built-in scanner and a wall x = -60 on it, 100 mm high.
Scene floor_and_wall() {
    Scene scene = built_in_scene();
    scene.channel.sheet.bow2 = 0;
    const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
               z = Eigen::Vector3d::UnitZ();
    scene.objects = {plate("floor", {260, 240}, x, y, {70, 0, -450}),
                     plate("wall", {240, 100}, y, z, {-60, 0, -400})};
    scene.reflection.bounce = true;
    return scene;
}

SurfaceHit on_wall(const SceneGeometry& geometry, double height) {
    return geometry.first_hit({-50, 1, -450 + height}, -Eigen::Vector3d::UnitX());
}

/// What one spot (area element `cosines` / r^2) of the floor throws on the wall, no square roots
/// of the code under test: cos cos / r^2 by components.
double exchange(const Eigen::Vector3d& floor, const Eigen::Vector3d& wall) {
    const Eigen::Vector3d way = wall - floor;
    const double r2 = way.squaredNorm();
    return way.z() * (floor.x() - wall.x()) / (r2 * r2);
}

TEST(FormFactor, OfARectangleOppositeItsCornerIsTheClosedForm) {
    // Differential element under the corner of a parallel rectangle a x b at distance c.
    for (const auto& [a, b, c] : {std::tuple{1.0, 2.0, 0.5}, {3.0, 0.2, 1.0}, {40.0, 50.0, 0.1}}) {
        const double p = std::hypot(a, c), q = std::hypot(b, c);
        const double expected = (a / p * std::atan(b / p) + b / q * std::atan(a / q)) / (2 * kPi);
        const double found = parallelogram_irradiance({0, 0, 0}, {0, 0, 1}, {a / 2, b / 2, c},
                                                      {a / 2, 0, 0}, {0, b / 2, 0}) /
                             kPi;
        EXPECT_NEAR(found, expected, 1e-12) << a << " " << b << " " << c;
    }
}

TEST(FormFactor, SeesOnlyWhatStandsAboveTheHorizon) {
    // A wall that runs from below the horizon to above gives what its upper half gives.
    const Eigen::Vector3d up(0, 0, 1), side(0, 3, 0);
    const double whole =
        parallelogram_irradiance({0, 0, 0}, up, {1, 0, 0}, side, Eigen::Vector3d(0, 0, 2));
    const double half =
        parallelogram_irradiance({0, 0, 0}, up, {1, 0, 1}, side, Eigen::Vector3d(0, 0, 1));
    EXPECT_NEAR(whole, half, 1e-12);
    EXPECT_EQ(parallelogram_irradiance({0, 0, 0}, up, {1, 0, -2}, side, {0, 0, 1}), 0);
}

TEST(GlossyLobe, IsReciprocalAndSendsOutWhatItGets) {
    const Eigen::Vector3d n(0, 0, 1), a = Eigen::Vector3d(0.3, 0.1, 1).normalized(),
                                      b = Eigen::Vector3d(-0.8, 0.2, 0.6).normalized();
    for (double alpha : {0.05, 0.2, 0.6, 1.0}) {
        EXPECT_NEAR(glossy_lobe(n, a, b, alpha), glossy_lobe(n, b, a, alpha), 1e-12);
        // Seen along the normal it is D(1) / 4 = 1 / (4 pi alpha^2).
        EXPECT_NEAR(glossy_lobe(n, n, n, alpha), 1 / (4 * kPi * alpha * alpha), 1e-9);
    }
    // All light comes out again where shadowing is small: within 1 % for alpha 0.05.
    double sum = 0;
    constexpr int kSteps = 4000;
    for (int i = 0; i < kSteps; ++i) {
        const double angle = (i + 0.5) / kSteps * kPi / 2;
        const Eigen::Vector3d out(std::sin(angle), 0, std::cos(angle));
        sum +=
            glossy_lobe(n, n, out, 0.05) * out.z() * 2 * kPi * std::sin(angle) * kPi / 2 / kSteps;
    }
    EXPECT_NEAR(sum, 1.0, 0.01);  // share of the light
}

TEST(Bounce, IsAlbedoTimesTheIntegralOfTheSheetsPower) {
    const Scene scene = floor_and_wall();
    const SceneGeometry geometry(scene);
    const Beam beam(scene);
    const BounceLight bounce(scene, beam, geometry);
    const double travel = scene.axis.max - scene.axis.min;
    constexpr int kLines = 1200, kRays = 600;
    for (double height : {4.0, 12.0, 40.0, 80.0}) {
        const Eigen::Vector3d q(-60, 1, -450 + height);
        double expected = 0;
        for (int i = 0; i < kLines; ++i) {
            const double s = scene.axis.min - 0.05 * travel + (i + 0.5) / kLines * 1.1 * travel;
            for (int j = 0; j < kRays; ++j) {
                const double phi = 0.9 * ((j + 0.5) / kRays - 0.5);
                const BeamRay ray = beam.ray(s, phi);
                const Eigen::Vector3d p =
                    ray.origin + (-450 - ray.origin.z()) / ray.direction.z() * ray.direction;
                if (p.x() < -60 || p.x() > 200 || std::abs(p.y()) > 120) continue;
                expected += ray.mw_per_rad * exchange(p, q);
            }
        }
        expected *= 0.7 / kPi * (1.1 * travel / kLines) * (0.9 / kRays);
        const double found = bounce.dose(on_wall(geometry, height));
        EXPECT_NEAR(found / expected, 1.0, 0.015) << height;  // patches up to 0.2 of the distance
    }
}

TEST(Bounce, NearACreaseIsHalfOfWhatTheOtherFaceScatters) {
    // Radiosity: from a wall's foot an endless evenly lit floor has the form factor 1/2, up to
    // length L at height b (1 - b / sqrt(b^2 + L^2)) / 2.
    const Scene scene = floor_and_wall();
    const SceneGeometry geometry(scene);
    const Beam beam(scene);
    const BounceLight bounce(scene, beam, geometry);
    const double height = 2;
    const SurfaceHit floor = geometry.first_hit({-57, 1, -440}, -Eigen::Vector3d::UnitZ());
    const auto passing = beam.passing(floor, 0);
    ASSERT_TRUE(passing);
    // The direct light, from the pulse that a pixel sees.
    const double floor_dose =
        passing->rate / (beam.electrons_per_mw_mm2() * 0.7) * std::sqrt(2 * kPi) / passing->per_s;
    const double form_factor = (1 - height / std::hypot(height, 260.0)) / 2;
    EXPECT_NEAR(bounce.dose(on_wall(geometry, height)) / (0.7 * floor_dose * form_factor), 1.0,
                0.03);  // the light on the floor is even to that
}

TEST(Bounce, AFlatSurfaceThrowsNothingOnItself) {
    // Turned by angles whose normals single precision rounds: a piece of the plane itself must not
    // count as one just above it.
    Scene scene = floor_and_wall();
    for (double degrees = 50; degrees < 70; degrees += 1) {
        const double angle = degrees / 180 * kPi;
        scene.objects = {plate("slope", {200, 160}, {std::cos(angle), 0, std::sin(angle)},
                               Eigen::Vector3d::UnitY(), {0, 0, -450})};
        const SceneGeometry geometry(scene);
        const Beam beam(scene);
        const BounceLight bounce(scene, beam, geometry);
        for (double x = -20; x < 20; x += 0.7) {
            const SurfaceHit hit = geometry.first_hit({x, 1, -300}, -Eigen::Vector3d::UnitZ());
            ASSERT_GE(hit.object, 0);
            ASSERT_EQ(bounce.dose(hit), 0) << degrees << " deg, x " << x;
        }
    }
}

TEST(Bounce, OfAPixelAddsUpToItsDoseAndIsBroad) {
    const Scene scene = floor_and_wall();
    const SceneGeometry geometry(scene);
    const Beam beam(scene);
    const BounceLight bounce(scene, beam, geometry);
    const SurfaceHit hit = on_wall(geometry, 20);
    const auto passing = beam.passing(hit, 0);
    ASSERT_TRUE(passing);
    std::vector<StripeLight> lights;
    bounce.add(hit, {0, 0, 0}, 7, lights);
    double dose = 0;
    for (const StripeLight& light : lights) {
        EXPECT_EQ(light.pixel, 7u);
        EXPECT_LE(static_cast<double>(light.per_s), passing->per_s * 1.3);  // no sharper than beam
        dose +=
            std::sqrt(2 * kPi) * static_cast<double>(light.rate) / static_cast<double>(light.per_s);
    }
    EXPECT_NEAR(dose / (bounce.dose(hit) * 0.7 * beam.electrons_per_mw_mm2()), 1.0, 0.01);
}

TEST(Mirrors, ShowTheSheetWhereItsImageMeetsTheSurface) {
    Scene scene = floor_and_wall();
    scene.reflection = {.bounce = false, .mirrors = true};
    scene.objects[1].mirror = true;
    scene.objects[1].albedo = 0.9;
    const SceneGeometry geometry(scene);
    const Beam beam(scene);
    const MirrorLight mirrors(scene, beam, geometry);
    int seen = 0;
    for (double x = -55; x < 20; x += 5) {
        const SurfaceHit hit = geometry.first_hit({x, 3, -440}, -Eigen::Vector3d::UnitZ());
        std::vector<StripeLight> lights;
        mirrors.add(hit, {0, 0, 0}, 1, 5, lights);
        if (lights.empty()) continue;
        ++seen;
        ASSERT_EQ(lights.size(), 1u);
        // The unfolded way: the sheet at that s holds the point's image behind the wall.
        const Rigid3 world_from_camera = scan_from_camera(scene.channel, 0);
        const LaserSheet sheet = sheet_at(scene.channel, lights[0].s0);
        const Eigen::Vector3d image =
            world_from_camera.inverse() * Eigen::Vector3d(-120 - x, hit.point.y(), hit.point.z());
        EXPECT_LT(std::abs(signed_distance(sheet, image)), 1e-6);  // mm
        const double range = (image - sheet.apex).norm();
        const double cosine =
            ((world_from_camera * sheet.apex).z() + 450) / range;  // on the floor, unchanged
        const double irradiance = scene.laser_power_mw * cosine /
                                  (0.9 * range * std::sqrt(2 * kPi) * sigma_at(sheet, image));
        EXPECT_NEAR(static_cast<double>(lights[0].rate),
                    0.9 * 0.7 * irradiance * beam.electrons_per_mw_mm2(),
                    1e-5 * static_cast<double>(lights[0].rate));
    }
    EXPECT_GE(seen, 8);
}

TEST(Reflection, ComesBackFromTextAndIsRefusedWhereItIsNotSimulated) {
    Scene scene = floor_and_wall();
    scene.reflection.mirrors = true;
    scene.objects[0].specular = 0.2;
    scene.objects[0].gloss = 0.15;
    const Scene back = parse_scene(format_scene(scene), "text", ".");
    EXPECT_TRUE(back.reflection.bounce && back.reflection.mirrors);
    EXPECT_EQ(back.objects[0].specular, 0.2);
    EXPECT_EQ(back.objects[0].gloss, 0.15);
    EXPECT_FALSE(built_in_scene().reflection.bounce || built_in_scene().reflection.mirrors);

    Scene glaring = scene;
    glaring.objects[0].specular = 0.4;
    EXPECT_NE(validate(glaring).find("specular"), std::string::npos) << validate(glaring);
    Scene ball = scene;
    ball.objects[1].shape = SceneShape::sphere;
    ball.objects[1].radius_mm = 10;
    ball.objects[1].mirror = true;
    EXPECT_NE(validate(ball).find("mirror"), std::string::npos) << validate(ball);
    Scene rail = read_scene(example_scene("rail.toml"));
    rail.reflection.bounce = true;
    EXPECT_NE(validate(rail).find("swept"), std::string::npos) << validate(rail);
}

}  // namespace
}  // namespace stria

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/geometry/parallel.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

Scene quiet_example(const std::string& name, bool sphere_only) {
    Scene scene = read_scene(example_scene(name));
    scene.sensor.noise = false;
    scene.sensor.bits = 16;
    scene.sensor.gain_e_per_dn = 0.5;
    scene.sensor.full_well_e = 30000;
    scene.sensor.black_dn = 0;
    scene.ambient_level = 0;
    if (sphere_only) scene.objects.resize(1);
    return scene;
}

struct SphereFit {
    std::size_t points = 0;
    double median_mm = 0, p95_mm = 0;
};

/// Centroid of each row's stripe in the frame at s, triangulated with the truth, against the
/// sphere.
SphereFit sphere_errors(const Scene& scene, std::initializer_list<double> positions) {
    SimulatedScanner scanner(scene, 1);
    const Channel channel = scanner.truth_model().channels.front();
    const Eigen::Vector3d centre = scene.objects[0].world_from_object.translation;
    std::vector<double> errors;
    for (double s : positions) {
        const Frame frame = record_still(scanner, s, 1);
        for (int y = 0; y < frame.height; ++y) {
            double sum = 0, moment = 0;
            for (int x = 0; x < frame.width; ++x) {
                sum += frame.sample(x, y);
                moment += x * frame.sample(x, y);
            }
            if (sum < 20000) continue;
            const auto t = triangulate(channel, Eigen::Vector2d(moment / sum, y), s);
            if (!t) continue;
            const Eigen::Vector3d from_centre = t->point_in_scan - centre;
            // Rows that run along the stripe at the sphere's rim have no one crossing.
            const double across = -from_centre.normalized().dot(t->ray_in_scan);
            const double u_slope =
                std::abs(from_centre.normalized().dot(t->d_point_d_u)) / t->d_point_d_u.norm();
            if (across < 0.5 || u_slope < 0.35) continue;
            errors.push_back(std::abs(from_centre.norm() - scene.objects[0].radius_mm));
        }
    }
    SphereFit fit;
    fit.points = errors.size();
    if (errors.empty()) return fit;
    std::sort(errors.begin(), errors.end());
    fit.median_mm = errors[errors.size() / 2];
    fit.p95_mm = errors[errors.size() * 95 / 100];
    return fit;
}

// The centroid of a beam of 0.15 mm across a curved, unevenly lit surface lies beside its centre by
// about sigma^2 times the curvature and the slope of the brightness: some micrometres.
TEST(Rail, LitPointsLieOnTheSphere) {
    const SphereFit fit = sphere_errors(quiet_example("rail.toml", true), {-12.0, 0.0, 9.0});
    EXPECT_GT(fit.points, 100u);
    EXPECT_LT(fit.median_mm, 0.003);
    EXPECT_LT(fit.p95_mm, 0.02);
}

TEST(Turntable, LitPointsLieOnTheSphere) {
    const SphereFit fit = sphere_errors(quiet_example("turntable.toml", true), {0.0, 1.3, 4.0});
    EXPECT_GT(fit.points, 100u);
    EXPECT_LT(fit.median_mm, 0.003);
    EXPECT_LT(fit.p95_mm, 0.02);
}

TEST(TrueRange, LiesOnTheSurfacesAndInTheSheet) {
    for (const char* name : {"rail.toml", "turntable.toml"}) {
        const Scene scene = quiet_example(name, true);
        SimulatedScanner scanner(scene, 1);
        const std::vector<double> s = {-0.05, 0.0, 0.1, 0.15};
        const RangeImage truth = scanner.true_range(s);
        ASSERT_EQ(truth.width, 4);
        EXPECT_EQ(truth.stations.size(), 4u);
        std::size_t points = 0;
        for (int k = 0; k < truth.width; ++k) {
            const Rigid3 camera =
                scan_from_camera(scene.channel, s[static_cast<std::size_t>(k)]).inverse();
            for (int v = 0; v < truth.height; ++v) {
                if (!truth.has(k, v)) continue;
                ++points;
                const Eigen::Vector3d p = truth.at(k, v).position;
                const Eigen::Vector3d centre = scene.objects[0].world_from_object.translation;
                EXPECT_NEAR((p - centre).norm(), 25, 1e-9);
                EXPECT_NEAR(signed_distance(scene.channel.sheet, camera * p), 0, 1e-6);
                const auto pixel = project(scene.channel.camera, camera * p);
                EXPECT_NEAR(pixel->y(), v, 1e-6);
            }
        }
        EXPECT_GT(points, 200u) << name;
    }
}

TEST(TrueRange, OfASweptCameraIsTheFirstSurfaceOfEachPixel) {
    const Scene scene = read_scene(example_scene("swept.toml"));
    SimulatedScanner scanner(scene, 1);
    const RangeImage truth = scanner.true_range();
    ASSERT_EQ(truth.width, scene.channel.camera.width);
    EXPECT_GT(valid_count(truth), 200000u);
    const Eigen::Vector3d centre = scene.objects[0].world_from_object.translation;
    const Rigid3 plate = scene.objects[1].world_from_object;
    for (int y = 3; y < truth.height; y += 17) {
        for (int x = 3; x < truth.width; x += 13) {
            if (!truth.has(x, y)) continue;
            const RangePoint& point = truth.at(x, y);
            const double to_sphere = (point.position - centre).norm() - 40;
            const double to_plate = (plate.inverse() * point.position).z();
            EXPECT_LT(std::min(std::abs(to_sphere), std::abs(to_plate)), 1e-9);
            const auto same = triangulate(scene.channel, Eigen::Vector2d(x, y), point.s);
            ASSERT_TRUE(same);
            EXPECT_LT((same->point_in_scan - point.position).norm(), 1e-7);
            const auto error =
                scanner.error_along(point.position + 0.3 * point.error_direction.cast<double>(),
                                    point.error_direction.cast<double>());
            ASSERT_TRUE(error);
            EXPECT_NEAR(*error, 0.3, 1e-6);  // the direction is stored in float
        }
    }
}

TEST(Determinism, SeedsAndThreads) {
    for (const char* name : {"swept.toml", "rail.toml"}) {
        const Scene scene = read_scene(example_scene(name));
        const auto bytes = [&](unsigned seed, int threads) {
            set_thread_count(threads);
            SimulatedScanner scanner(scene, seed);
            const double middle = (scene.axis.min + scene.axis.max) / 2;
            const double step = (scene.axis.max - scene.axis.min) / 400;
            std::vector<std::uint8_t> all;
            for (const Frame& frame : record_sweep(scanner, middle, middle + 4 * step, step).frames)
                all.insert(all.end(), frame.bytes.begin(), frame.bytes.end());
            set_thread_count(0);
            return all;
        };
        const std::vector<std::uint8_t> one = bytes(1, 1);
        ASSERT_FALSE(one.empty());
        EXPECT_EQ(one, bytes(1, 2)) << name;
        EXPECT_NE(one, bytes(2, 2)) << name;
    }
}

// Rolling shutter: row y is exposed y row times later, so the stripe in it belongs to a later s.
TEST(RollingShutter, EachRowSeesTheSheetOfItsOwnMoment) {
    Scene scene = quiet_example("swept.toml", false);
    scene.objects.erase(scene.objects.begin());  // the plate alone
    scene.views.clear();
    scene.channel.sheet.waist_sigma_mm = 0.5;
    scene.sensor.exposure_us = 200;
    scene.sensor.row_time_us = 20;  // 12.8 ms from first row to last
    scene.sensor.min_frame_period_us = 14000;
    SimulatedScanner scanner(scene, 1);
    const Channel channel = scanner.truth_model().channels.front();
    const Rigid3 plate = scene.objects[0].world_from_object;
    Devices d = scanner.devices();
    ASSERT_TRUE(d.camera.configure({200 * kNsPerUs, 14 * kNsPerMs}));
    ASSERT_TRUE(d.axis.move_to(-0.05, kNsPerSecond));
    ASSERT_TRUE(d.laser.on(1));
    ASSERT_TRUE(d.axis.start_sweep(-0.05, 0.05, 1.0));
    ASSERT_TRUE(d.camera.start());
    Frame frame;
    for (int i = 0; i < 4; ++i) ASSERT_TRUE(d.camera.next_frame(frame, 10 * kNsPerSecond));
    double worst = 0;
    int rows = 0;
    for (int y = 100; y < 540; y += 20) {
        double sum = 0, moment = 0;
        for (int x = 0; x < frame.width; ++x) {
            sum += frame.sample(x, y);
            moment += x * frame.sample(x, y);
        }
        if (sum < 1000) continue;
        const double s = scanner.true_axis_position(frame.row_time(y));
        const auto t = triangulate(channel, Eigen::Vector2d(moment / sum, y), s);
        ASSERT_TRUE(t);
        worst = std::max(worst, std::abs((plate.inverse() * t->point_in_scan).z()));
        ++rows;
    }
    EXPECT_GT(rows, 15);
    EXPECT_LT(worst, 0.02);  // mm: the centroid across a beam of 0.5 mm; a row's error would be 0.4
}

TEST(Faults, TimingJitterMovesTheStripeAgainstItsStamp) {
    Scene scene = quiet_example("swept.toml", false);
    scene.objects.erase(scene.objects.begin());
    scene.views.clear();
    scene.sensor.exposure_us = 200;
    const auto spread_us = [&](double jitter_us) {
        scene.fault.timing_jitter_us = jitter_us;
        SimulatedScanner scanner(scene, 1);
        const Channel channel = scanner.truth_model().channels.front();
        const Rigid3 plate = scene.objects[0].world_from_object;
        const double speed = 0.8;
        const SimSweep sweep = record_sweep(scanner, -0.04, 0.04, speed * 0.002);
        double squares = 0;
        int count = 0;
        for (std::size_t k = 0; k < sweep.frames.size(); ++k) {
            double sum = 0, moment = 0;
            for (int x = 0; x < scene.channel.camera.width; ++x) {
                sum += sweep.frames[k].sample(x, 320);
                moment += x * sweep.frames[k].sample(x, 320);
            }
            if (sum < 1000) continue;
            const auto t = triangulate(channel, Eigen::Vector2d(moment / sum, 320), sweep.s[k]);
            const Eigen::Vector3d normal = plate.rotation.col(2);
            const double off = normal.dot(t->point_in_scan - plate.translation);
            const double late_s = off / normal.dot(t->d_point_d_s) / speed;
            squares += late_s * late_s * 1e12;
            ++count;
        }
        EXPECT_GT(count, 40);
        return std::sqrt(squares / count);
    };
    EXPECT_LT(spread_us(0), 3);
    EXPECT_NEAR(spread_us(50), 50, 20);  // 50 frames give a spread to 10 %
}

TEST(Determinism, MeshesTooWhateverTheThreads) {
    // A bumpy ball of 20 000 triangles, so that trees are built in parallel.
    auto mesh = std::make_shared<TriMesh>();
    constexpr unsigned kRings = 100;
    for (unsigned i = 0; i <= kRings; ++i)
        for (unsigned j = 0; j < kRings; ++j) {
            const double polar = M_PI * i / kRings, around = 2 * M_PI * j / kRings;
            const double r = 60 * (1 + 0.05 * std::sin(7 * around) * std::sin(5 * polar));
            mesh->positions.push_back({r * std::sin(polar) * std::cos(around),
                                       r * std::sin(polar) * std::sin(around),
                                       r * std::cos(polar)});
        }
    for (unsigned i = 0; i < kRings; ++i)
        for (unsigned j = 0; j < kRings; ++j) {
            const unsigned a = i * kRings + j, b = i * kRings + (j + 1) % kRings;
            mesh->triangles.push_back({a, a + kRings, b});
            mesh->triangles.push_back({b, a + kRings, b + kRings});
        }
    Scene scene = built_in_scene();
    scene.channel.camera = {.kind = LensKind::pinhole,
                            .width = 320,
                            .height = 256,
                            .fx = 460,
                            .fy = 460,
                            .cx = 160,
                            .cy = 128};
    SceneObject part;
    part.name = "part";
    part.shape = SceneShape::mesh;
    part.mesh = mesh;
    part.world_from_object.translation = {0, 0, -420};
    scene.objects = {part};
    const auto picture = [&](int threads) {
        set_thread_count(threads);
        SimulatedScanner scanner(scene, 1);
        std::vector<std::uint8_t> bytes = record_still(scanner, 0, 1).bytes;
        set_thread_count(0);
        return bytes;
    };
    const std::vector<std::uint8_t> one = picture(1);
    EXPECT_EQ(one, picture(2));
    EXPECT_EQ(one, picture(3));
    EXPECT_GT(*std::max_element(one.begin(), one.end()), 60);
}

TEST(Views, PutTheObjectsWhereTheySay) {
    const Scene scene = read_scene(example_scene("swept.toml"));
    SimulatedScanner scanner(scene, 1);
    ASSERT_EQ(scanner.view_count(), 3);
    const auto sphere_points = [&](const Eigen::Vector3d& centre) {
        const RangeImage truth = scanner.true_range();
        int on_it = 0;
        for (std::size_t i = 0; i < truth.cell_count(); i += 7)
            on_it += truth.mask[i] != 0 &&
                     std::abs((truth.points[i].position - centre).norm() - 40) < 1e-6;
        return on_it;
    };
    EXPECT_GT(sphere_points({-20, 5, -400}), 1000);
    scanner.set_view(1);
    EXPECT_EQ(sphere_points({-20, 5, -400}), 0);
    scanner.set_view(2);
    EXPECT_GT(sphere_points({30, -10, -390}), 1000);
    EXPECT_THROW(scanner.set_view(3), std::invalid_argument);
}

TEST(NominalModel, DiffersFromTheTruthByAsMuchAsTheSceneSays) {
    const Scene scene = built_in_scene();
    double turned = 0, focal = 0;
    constexpr int kSeeds = 300;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
        Scene small = scene;
        small.channel.camera.width = 8;
        small.channel.camera.height = 8;
        small.objects.clear();
        SimulatedScanner scanner(small, seed);
        const Channel nominal = scanner.nominal_model().channels.front();
        const Channel truth = scanner.truth_model().channels.front();
        EXPECT_EQ(validate(scanner.nominal_model()), "");
        turned += (nominal.axis.mirror.normal0 - truth.axis.mirror.normal0).squaredNorm() / kSeeds;
        focal += std::pow(nominal.camera.fx / truth.camera.fx - 1, 2) / kSeeds;
        EXPECT_EQ(nominal.camera.distortion[0], 0);
        EXPECT_EQ(nominal.axis.delay_ns, 0);
    }
    // A direction turns by two of the three angles; 300 seeds give a mean square to 8 %.
    EXPECT_NEAR(turned, 2 * 0.01 * 0.01, 0.25 * 2e-4);
    EXPECT_NEAR(focal, 1e-4, 0.35e-4);
}

}  // namespace
}  // namespace stria

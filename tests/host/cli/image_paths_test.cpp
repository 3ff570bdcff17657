#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "firmware/core/median.h"
#include "host/cli/recording_range.h"
#include "host/geometry/range_grid.h"
#include "host/local/local_scanner.h"
#include "host/scan/path_table.h"
#include "sim/scene.h"
#include "tests/support/machine_scenes.h"

/// Spacetime along image paths on a rail and a turntable, against spatial peaks of the same frames,
/// on the simulator's truth.
namespace stria {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(PathTable, FollowsTheExactPathOfEverySurfacePoint) {
    for (const MachineKind kind : {MachineKind::rail, MachineKind::turntable}) {
        const Scene scene = test_support::machine_scenes(kind, 3).sphere_scene;
        const Channel& channel = scene.channel;
        const PathTable table = make_path_table(channel, "");
        std::mt19937 rng(5);
        std::uniform_real_distribution<double> unit(0, 1);
        double worst = 0;
        int seen = 0;
        for (int trial = 0; trial < 20000; ++trial) {
            const Vector2d pixel(unit(rng) * (channel.camera.width - 1),
                                 unit(rng) * (channel.camera.height - 1));
            const double s0 = 2 * unit(rng) - 1;  // mm or rad: paths do not depend on it
            const auto path = path_at(table, pixel.x(), pixel.y());
            const auto hit = triangulate(channel, pixel, s0);
            if (!path || !hit) continue;
            const double ds = 3 * path->width_s * (2 * unit(rng) - 1);
            const auto exact = project(
                channel.camera, scan_from_camera(channel, s0 + ds).inverse() * hit->point_in_scan);
            ASSERT_TRUE(exact);
            const Vector2d told(pixel.x() + ds * (path->du + 0.5 * ds * path->ddu),
                                pixel.y() + ds * (path->dv + 0.5 * ds * path->ddv));
            worst = std::max(worst, (told - *exact).norm());
            ++seen;
        }
        std::printf("%s: worst %.5f px of %d\n", name_of(kind), worst, seen);
        EXPECT_GT(seen, 10000);
        EXPECT_LE(worst, 0.02);  // px
    }
}

struct Figures {
    std::size_t points = 0, fallbacks = 0;
    double rms_mm = 0, mean_mm = 0, sigma_ratio = 0, worst_mm = 0;
};

template <typename Error>
Figures judge(const RangeImage& image, int border_cells, const Error& error) {
    const auto border = border_distance(image, range_triangles(image), border_cells + 1);
    Figures figures;
    std::vector<double> errors, normalised;
    for (std::size_t i = 0; i < image.cell_count(); ++i) {
        if (!image.mask[i] || border[i] <= border_cells) continue;
        const RangePoint& p = image.points[i];
        const auto [off, normal] = error(p.position);
        errors.push_back(off);
        figures.fallbacks += (p.flags & kPulseSpatialFallback) != 0;
        normalised.push_back(
            off / (normal.dot(p.error_direction.template cast<double>()) * double{p.sigma_mm}));
    }
    figures.points = errors.size();
    if (errors.empty()) return figures;
    double squares = 0;
    for (const double e : errors) {
        squares += e * e;
        figures.worst_mm = std::max(figures.worst_mm, std::abs(e));
    }
    double sum = 0;
    for (const double e : errors) sum += e;
    figures.mean_mm = sum / static_cast<double>(errors.size());
    figures.rms_mm = std::sqrt(squares / static_cast<double>(errors.size()));
    const double middle = median(normalised);
    for (double& x : normalised) x = std::abs(x - middle);
    figures.sigma_ratio = 1.4826 * median(normalised);
    return figures;
}

/// Spacetime and spatial range images of one sweep's frames, in the scene's own model.
struct BothWays {
    RangeImage spatial, spacetime;
};

BothWays scan_both_ways(const Scene& scene, double from, double to, double step) {
    ScannerModel model;
    model.channels.push_back(scene.channel);
    LocalScanner local(scene, {});
    ScanPlan plan;
    plan.mode = StripeMode::spacetime;
    plan.record = RecordWhat::frames;
    plan.from = from;
    plan.to = to;
    plan.step = step;
    RecordingContents frames = local.run(plan);
    BothWays ways;
    ways.spacetime = range_of(frames, model, "spacetime").image;
    frames.snapshot.plan.mode = StripeMode::spatial;
    ways.spatial = range_of(frames, model, "spatial").image;
    return ways;
}

void print(const char* what, const Figures& f) {
    std::printf(
        "%s: %zu points, %zu fallbacks, mean %+.4f mm, rms %.4f mm, worst %.4f mm, "
        "sigma ratio %.3f\n",
        what, f.points, f.fallbacks, f.mean_mm, f.rms_mm, f.worst_mm, f.sigma_ratio);
}

// A sphere's shading and curvature pull spatial peaks; along image paths they do not. On a
// turntable the light on a point changes while it turns, which the range image takes back; the beam
// is narrow enough there for paths near the axis to be longer than it.
TEST(ImagePaths, MeasureASphereWithHonestSigma) {
    for (const MachineKind kind : {MachineKind::rail, MachineKind::turntable}) {
        const bool rail = kind == MachineKind::rail;
        Scene scene = test_support::machine_scenes(kind, 3).sphere_scene;
        scene.laser_power_mw *= rail ? 0.6 : 0.3;  // no sample saturates
        if (!rail) scene.channel.sheet.waist_sigma_mm = 0.3;
        const Vector3d centre = scene.objects.front().world_from_object.translation;
        const auto off_sphere = [&](const Vector3d& p) {
            return std::pair((p - centre).norm() - test_support::kSphereRadiusMm,
                             Vector3d((p - centre).normalized()));
        };
        const double reach = rail ? 12 : 0.25, step = rail ? 0.25 : 0.006;
        const BothWays ways = scan_both_ways(scene, -reach, reach, step);
        const Figures spatial = judge(ways.spatial, 4, off_sphere);
        const Figures spacetime = judge(ways.spacetime, 4, off_sphere);
        std::printf("%s\n", name_of(kind));
        print("  spatial", spatial);
        print("  spacetime", spacetime);
        EXPECT_GT(spacetime.points, 3000U);
        EXPECT_LT(spacetime.fallbacks, spacetime.points / 4);
        EXPECT_GE(spacetime.sigma_ratio, 0.8);
        EXPECT_LE(spacetime.sigma_ratio, 1.25);
        EXPECT_LT(spacetime.rms_mm, (rail ? 0.6 : 0.7) * spatial.rms_mm);
    }
}

/// A card of two reflectances, 10:1, in stripes along the laser's line, noise-free.
Scene card_scene(MachineKind kind) {
    Scene scene = test_support::machine_scenes(kind, 3).sphere_scene;
    const Vector3d middle(0, 0, kind == MachineKind::rail ? -450 : 0);
    scene.sensor.noise = false;
    scene.sensor.bits = 12;
    scene.sensor.gain_e_per_dn /= 16;
    scene.ambient_level = 0;
    scene.laser_power_mw *= 0.4;
    SceneObject card;
    card.name = "card";
    card.shape = SceneShape::plane;
    card.size_mm = {60, 40};
    card.corner_mm = -card.size_mm / 2;
    card.albedo = 0.8;
    card.world_from_object.translation = middle;
    if (kind == MachineKind::turntable) {
        Eigen::Matrix3d upright;  // the card's x along the table's x, its face to the camera at -y
        upright << 1, 0, 0, 0, 0, -1, 0, 1, 0;
        card.world_from_object = {upright, {0, -22, 0}};
    }
    GreyImage stripes;
    stripes.width = 400;
    stripes.height = 1;
    for (int x = 0; x < stripes.width; ++x)
        stripes.values.push_back(x < stripes.width / 2 ? 250 : 25);
    card.texture = "stripes.png";
    card.texture_size_mm = {20, 40};  // edges every 10 mm
    card.texture_image = std::make_shared<const GreyImage>(stripes);
    scene.objects = {card};
    return scene;
}

// Must beat spatial peaks at a 10:1 edge by 60 % where the footprint is under 0.3 of the beam.
TEST(ImagePaths, ReflectanceEdgesHardlyShow) {
    for (const MachineKind kind : {MachineKind::rail, MachineKind::turntable}) {
        const bool rail = kind == MachineKind::rail;
        const Scene scene = card_scene(kind);
        const Rigid3& card = scene.objects.front().world_from_object;
        const auto off_card = [&](const Vector3d& p) {
            const Vector3d normal = card.rotation.col(2);
            return std::pair(normal.dot(p - card.translation), normal);
        };
        const double reach = rail ? 15 : 0.35, step = rail ? 0.25 : 0.006;
        const BothWays ways = scan_both_ways(scene, -reach, reach, step);
        const Figures spatial = judge(ways.spatial, 2, off_card);
        const Figures spacetime = judge(ways.spacetime, 2, off_card);
        std::printf("%s\n", name_of(kind));
        print("  spatial", spatial);
        print("  spacetime", spacetime);
        EXPECT_GT(spacetime.points, 3000U);
        EXPECT_LT(spacetime.worst_mm, 0.4 * spatial.worst_mm);
        EXPECT_LT(spacetime.rms_mm, 0.4 * spatial.rms_mm);
    }
}

}  // namespace
}  // namespace stria

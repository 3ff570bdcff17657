#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

/// A small camera with the built-in scanner's geometry and one object; 16 bits without noise, so
/// that rounding is 1e-4 of a pulse.
Scene quiet_scene(const SceneObject& object) {
    Scene scene = built_in_scene();
    CameraModel& camera = scene.channel.camera;
    camera.width = 200;
    camera.height = 160;
    camera.fx = camera.fy = 290;
    camera.cx = 99.8;
    camera.cy = 79.1;
    scene.sensor.bits = 16;
    scene.sensor.gain_e_per_dn = 0.25;
    scene.sensor.full_well_e = 16000;
    scene.sensor.black_dn = 0;
    scene.sensor.noise = false;
    scene.laser_power_mw = 100;
    scene.ambient_level = 0;
    scene.channel.sheet.waist_sigma_mm = 0.6;
    scene.objects = {object};
    return scene;
}

SceneObject plate(const Rigid3& pose) {
    SceneObject object;
    object.name = "plate";
    object.shape = SceneShape::plane;
    object.size_mm = {300, 240};
    object.corner_mm = {-150, -120};
    object.world_from_object = pose;
    return object;
}

SceneObject ball(const Eigen::Vector3d& centre, double radius) {
    SceneObject object;
    object.name = "ball";
    object.radius_mm = radius;
    object.world_from_object.translation = centre;
    return object;
}

struct CentroidErrors {
    std::vector<double> relative;  ///< error along the ray over the range
};

/// Sweeps, takes each pixel's centroid in s, triangulates it with the truth and measures its
/// distance from the surface along the ray.
CentroidErrors centroid_errors(const Scene& scene,
                               const std::function<double(const Triangulation&)>& error_mm) {
    SimulatedScanner scanner(scene, 1);
    const SimSweep sweep = record_sweep(scanner, -0.15, 0.15, 0.001);
    const Channel channel = scanner.truth_model().channels.front();
    CentroidErrors result;
    for (int y = 0; y < channel.camera.height; ++y) {
        for (int x = 0; x < channel.camera.width; ++x) {
            double sum = 0, moment = 0;
            for (std::size_t k = 0; k < sweep.frames.size(); ++k) {
                sum += sweep.frames[k].sample(x, y);
                moment += sweep.frames[k].sample(x, y) * sweep.s[k];
            }
            const bool at_end =
                sweep.frames.front().sample(x, y) + sweep.frames.back().sample(x, y) > 0;
            if (sum < 20000 || at_end) continue;
            const auto point = triangulate(channel, Eigen::Vector2d(x, y), moment / sum);
            if (!point) continue;
            result.relative.push_back(error_mm(*point) / point->point_in_scan.norm());
        }
    }
    return result;
}

double at_share(std::vector<double> values, double share) {
    for (double& v : values) v = std::abs(v);
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST(Optics, CentroidOfASweptPulseLiesOnThePlane) {
    const Rigid3 pose{rotation_from_vector({0.15, 0.25, 0}), {0, 0, -410}};
    const Scene scene = quiet_scene(plate(pose));
    const Eigen::Vector3d normal = pose.rotation.col(2);
    const CentroidErrors errors = centroid_errors(scene, [&](const Triangulation& t) {
        return normal.dot(t.point_in_scan - pose.translation) / normal.dot(t.ray_in_scan);
    });
    ASSERT_GT(errors.relative.size(), 15000u);
    RecordProperty("median", std::to_string(at_share(errors.relative, 0.5)));
    RecordProperty("p99", std::to_string(at_share(errors.relative, 0.99)));
    // What is left: 16-bit rounding, the 5.5 sigma cut, and the beam's growth across the pixel.
    EXPECT_LT(at_share(errors.relative, 0.5), 5e-6);
    EXPECT_LT(at_share(errors.relative, 0.98), 1e-4);
}

TEST(Optics, CentroidOfASweptPulseLiesOnTheSphere) {
    const Eigen::Vector3d centre(0, 0, -400);
    const double radius = 60;
    const Scene scene = quiet_scene(ball(centre, radius));
    std::vector<double> inner;
    (void)centroid_errors(scene, [&](const Triangulation& t) {
        const Eigen::Vector3d from_centre = t.point_in_scan - centre;
        const double across = -from_centre.normalized().dot(t.ray_in_scan);
        const double error = (from_centre.norm() - radius) / across;
        // A pixel's footprint on a curved surface has its own mean: keep to 60 deg.
        if (across > 0.5) inner.push_back(error / t.point_in_scan.norm());
        return error;
    });
    ASSERT_GT(inner.size(), 2500u);
    EXPECT_LT(at_share(inner, 0.5), 2e-5);
    EXPECT_LT(at_share(inner, 0.98), 1e-4);
}

TEST(Optics, SignalIsLinearInExposureAndPower) {
    Scene scene = quiet_scene(plate({Eigen::Matrix3d::Identity(), {0, 0, -400}}));
    SimulatedScanner scanner(scene, 1);
    const auto total = [&](float power, double exposure_us) {
        const Frame frame = record_still(scanner, 0, power, exposure_us);
        double sum = 0;
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x) sum += frame.sample(x, y);
        return sum;
    };
    const double base = total(1, 400);
    ASSERT_GT(base, 1e6);
    EXPECT_NEAR(total(1, 800) / base, 2, 1e-3);
    EXPECT_NEAR(total(0.25F, 400) / base, 0.25, 1e-3);
    EXPECT_EQ(total(0, 400), 0);
}

// The light of one stripe must not depend on how finely pixels sample it: a camera of four times
// the pixels (a quarter of the area each) gathers the same sum from a stripe thinner than a pixel.
TEST(Optics, FinerPixelsGatherTheSameEnergy) {
    Scene scene = quiet_scene(plate({rotation_from_vector({0, 0.2, 0.1}), {0, 0, -400}}));
    scene.channel.sheet.waist_sigma_mm = 0.15;  // 0.1 px
    scene.channel.camera.distortion = {};
    const auto total_e = [](const Scene& given) {
        SimulatedScanner scanner(given, 1);
        const Frame frame = record_still(scanner, 0.01, 0.1F);
        double sum = 0;
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x) sum += frame.sample(x, y);
        return sum * given.sensor.gain_e_per_dn;
    };
    const double coarse = total_e(scene);
    Scene fine = scene;
    for (int halvings = 0; halvings < 2; ++halvings) {
        CameraModel& camera = fine.channel.camera;
        camera.width *= 2;
        camera.height *= 2;
        camera.fx *= 2;
        camera.fy *= 2;
        camera.cx = 2 * camera.cx + 0.5;
        camera.cy = 2 * camera.cy + 0.5;
        fine.sensor.pixel_um /= 2;
        fine.sensor.gain_e_per_dn /= 4;
        EXPECT_NEAR(total_e(fine) / coarse, 1, 2e-3) << halvings;
    }
}

// A plate before a wall: the shadow's edge on the wall, and the plate's own edge in the picture,
// against lines of sight drawn by hand.
TEST(Optics, ShadowAndSilhouetteEndWhereGeometryPutsThem) {
    Scene scene = quiet_scene(plate({Eigen::Matrix3d::Identity(), {0, 0, -450}}));
    SceneObject blade = plate({Eigen::Matrix3d::Identity(), {0, 0, -380}});
    blade.name = "blade";
    blade.size_mm = {300, 120};
    blade.corner_mm = {-150, 3};  // its lower edge is y = 3
    scene.objects.push_back(blade);
    scene.ambient_level = 0.3;
    scene.channel.sheet.bow2 = 0;
    SimulatedScanner scanner(scene, 1);
    const Channel channel = scanner.truth_model().channels.front();

    // Silhouette in ambient light: blade and wall are alike, so give the wall another albedo.
    Scene with_dark_wall = scene;
    with_dark_wall.objects[0].albedo = 0.2;
    SimulatedScanner two_tone(with_dark_wall, 1);
    const Frame off = record_still(two_tone, 0, 0);
    for (int x : {40, 99, 160}) {
        double bright = 0, wall = off.sample(x, 155), front = off.sample(x, 20);
        for (int y = 20; y <= 155; ++y) bright += (off.sample(x, y) - wall) / (front - wall);
        // Rows 20.. above the edge: the edge's v is 19.5 + the number of bright rows.
        const Eigen::Vector3d ray = ray_through(channel.camera, {static_cast<double>(x), 78.0});
        const auto edge = project(channel.camera, Eigen::Vector3d(ray.x() * 380, -3, 380));
        EXPECT_NEAR(19.5 + bright, edge->y(), 0.04) << x;  // px: 16 rays a pixel
    }

    // Shadow: the laser lies at y = 0 like the camera, so the blade's edge y = 3 throws its shadow
    // along straight lines from the apex behind the mirror.
    const double s = 0.0;
    const LaserSheet sheet = sheet_at(channel, s);
    const Frame lit = record_still(scanner, s, 1);
    const Frame dark = record_still(scanner, s, 0);
    // Apex in the scan frame; light reaching the wall (z = -450) beside the blade (z = -380) stays
    // below the line through (y = 3, z = -380) seen from the apex.
    const Rigid3 scan = scan_from_camera(channel, 0);
    const Eigen::Vector3d apex = scan * sheet.apex;
    const double share = (-450 - apex.z()) / (-380 - apex.z());
    const double shadow_y = apex.y() + (3 - apex.y()) * share;
    const double seen_from_y = 3 * 450.0 / 380.0;  // camera at the origin
    const double top_y = std::min(shadow_y, seen_from_y);
    const double x_wall =
        (sheet.offset_mm - sheet.normal.z() * 450) / sheet.normal.x();  // sheet holds the y axis
    const auto top = project(channel.camera, Eigen::Vector3d(x_wall, -top_y, 450));
    ASSERT_TRUE(top);
    // Rows of the wall's stripe, each as a share of what it gives without the blade.
    Scene bare = scene;
    bare.objects.pop_back();
    SimulatedScanner without(bare, 1);
    const Frame lit_bare = record_still(without, s, 1), dark_bare = record_still(without, s, 0);
    double rows = 0;
    for (int y = 60; y < 120; ++y) {
        double sum = 0, whole = 0;
        for (int x = 0; x < lit.width; ++x) {
            if (std::abs(x - top->x()) > 12) continue;
            sum += lit.sample(x, y) - dark.sample(x, y);
            whole += lit_bare.sample(x, y) - dark_bare.sample(x, y);
        }
        rows += sum / whole;
    }
    EXPECT_NEAR(119.5 - rows, top->y(), 0.05);  // px: 16 rays a pixel
}

TEST(Optics, LensDistortionMovesTheTextureAsTheModelSays) {
    // A black plate with a white disc drawn as a texture: its centroid in the picture.
    auto texture = std::make_shared<GreyImage>(400, 400);
    for (int y = 0; y < 400; ++y)
        for (int x = 0; x < 400; ++x)
            texture->at(x, y) = std::hypot(x - 199.5, y - 199.5) < 60 ? 255 : 0;
    SceneObject object = plate({Eigen::Matrix3d::Identity(), {0, 0, -400}});
    object.size_mm = {20, 20};
    object.texture_size_mm = {20, 20};
    object.texture_image = texture;
    for (const Eigen::Vector2d& at : {Eigen::Vector2d(90, 60), Eigen::Vector2d(-100, 70)}) {
        object.corner_mm = at - Eigen::Vector2d(10, 10);
        Scene scene = quiet_scene(object);
        scene.ambient_level = 0.5;
        scene.channel.camera.distortion = {-0.3, 0.1, 1e-3, -2e-3, 0, 0, 0, 0};
        SimulatedScanner scanner(scene, 1);
        const Frame frame = record_still(scanner, 0, 0);
        double sum = 0, u = 0, v = 0;
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x) {
                sum += frame.sample(x, y);
                u += x * frame.sample(x, y);
                v += y * frame.sample(x, y);
            }
        const auto expected = project(scene.channel.camera, Eigen::Vector3d(at.x(), -at.y(), 400));
        ASSERT_GT(sum, 1000);
        EXPECT_NEAR(u / sum, expected->x(), 0.03);  // px: a disc of 4 px, 16 rays a border pixel
        EXPECT_NEAR(v / sum, expected->y(), 0.03);
    }
}

TEST(Optics, AmbientLevelIsAShareOfFullScale) {
    Scene scene = quiet_scene(plate({Eigen::Matrix3d::Identity(), {0, 0, -400}}));
    scene.objects[0].albedo = 0.5;
    scene.ambient_level = 0.2;
    SimulatedScanner scanner(scene, 1);
    const Frame frame = record_still(scanner, 0, 0);
    EXPECT_NEAR(frame.sample(100, 80) * scene.sensor.gain_e_per_dn,
                0.5 * 0.2 * full_scale_e(scene.sensor), 1);
}

TEST(Optics, AMirrorReturnsNothing) {
    Scene scene = quiet_scene(plate({Eigen::Matrix3d::Identity(), {0, 0, -400}}));
    scene.objects[0].mirror = true;
    scene.ambient_level = 0.2;
    SimulatedScanner scanner(scene, 1);
    const Frame frame = record_still(scanner, 0, 1);
    EXPECT_EQ(*std::max_element(frame.bytes.begin(), frame.bytes.end()), 0);
}

}  // namespace
}  // namespace stria

#include "host/registration/joint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>

#include "firmware/core/angle.h"
#include "host/geometry/align.h"
#include "host/geometry/parallel.h"
#include "tests/support/bumpy_shape.h"

namespace stria {
namespace {

using Eigen::Vector3d;
using testing::looking_from;
using testing::random_motion;
using testing::take_view;

struct Scene {
    std::vector<Rigid3> truth;
    std::vector<ScanSurface> scans;
};

Scene make_scene(int views, double sigma_mm, unsigned seed) {
    static const SurfaceTree shape(testing::make_bumpy_shape(1));
    std::mt19937 rng(seed);
    Scene scene;
    for (const Vector3d& direction : testing::spread_directions(views)) {
        scene.truth.push_back(looking_from(direction, 300));
        scene.scans.push_back(
            prepare_surface(take_view(shape, scene.truth.back(), {.sigma_mm = sigma_mm}, rng)));
    }
    return scene;
}

std::vector<ScanPose> disturbed(const Scene& scene, double angle_rad, double shift_mm,
                                std::mt19937& rng) {
    std::vector<ScanPose> poses(scene.truth.size());
    for (std::size_t i = 0; i < poses.size(); ++i)
        poses[i].world_from_scan = i == 0 ? scene.truth[0]
                                          : random_motion(scene.truth[i] * scene.scans[i].centre,
                                                          angle_rad, shift_mm, rng) *
                                                scene.truth[i];
    return poses;
}

double angle_between(const Rigid3& a, const Rigid3& b) {
    return vector_from_rotation(a.rotation * b.rotation.transpose()).norm();
}

TEST(RegisterJointly, FindsTheTruePosesOfNoisyViews) {
    const Scene scene = make_scene(8, 0.03, 1);
    std::mt19937 rng(2);
    const JointResult result = register_jointly(scene.scans, disturbed(scene, 3 * kDegree, 3, rng));
    ASSERT_TRUE(result.converged) << result.reason;
    for (std::size_t i = 0; i < scene.truth.size(); ++i) {
        const Rigid3& found = result.scans[i].world_from_scan;
        EXPECT_LT(angle_between(found, scene.truth[i]) / kDegree, 0.02) << i;
        const Vector3d centre = scene.scans[i].centre;
        EXPECT_LT((found * centre - scene.truth[i] * centre).norm(), 0.03) << i;  // mm
    }
    EXPECT_EQ(result.scans[0].world_from_scan.translation, scene.truth[0].translation);
    EXPECT_TRUE(result.scans[0].fixed);
    double variance = 0, count = 0;
    for (const ScanSurface& scan : scene.scans)
        for (const std::uint32_t sample : scan.samples) {
            variance += std::pow(scan.sigma_mm[sample], 2);
            count += 1;
        }
    // Two noisy points a match; the rest is what lies between points of a facet's curved plane.
    const double predicted = std::sqrt(2 * variance / count);
    EXPECT_NEAR(result.overlap_rms_mm, predicted, 0.2 * predicted);
    EXPECT_EQ(result.history.size(), static_cast<std::size_t>(result.iterations));
}

TEST(RegisterJointly, IsTheSameForAnyThreadCount) {
    const Scene scene = make_scene(5, 0.03, 3);
    std::mt19937 rng(4);
    const auto start = disturbed(scene, 2 * kDegree, 2, rng);
    set_thread_count(1);
    const JointResult one = register_jointly(scene.scans, start);
    set_thread_count(2);
    const JointResult two = register_jointly(scene.scans, start);
    set_thread_count(0);
    for (std::size_t i = 0; i < one.scans.size(); ++i) {
        EXPECT_EQ(one.scans[i].world_from_scan.rotation, two.scans[i].world_from_scan.rotation);
        EXPECT_EQ(one.scans[i].world_from_scan.translation,
                  two.scans[i].world_from_scan.translation);
        EXPECT_EQ(one.scans[i].covariance, two.scans[i].covariance);
    }
    EXPECT_EQ(one.overlap_rms_mm, two.overlap_rms_mm);
}

TEST(RegisterJointly, KeepsFixedScansAndFollowsThem) {
    const Scene scene = make_scene(5, 0.0, 5);
    std::mt19937 rng(6);
    auto start = disturbed(scene, 2 * kDegree, 2, rng);
    const Rigid3 moved = random_motion(Vector3d::Zero(), 1.0, 500, rng);  // the whole scene
    for (ScanPose& pose : start) pose.world_from_scan = moved * pose.world_from_scan;
    start[2].world_from_scan = moved * scene.truth[2];
    start[2].fixed = true;
    const JointResult result = register_jointly(scene.scans, start);
    ASSERT_TRUE(result.converged) << result.reason;
    EXPECT_EQ(result.scans[2].world_from_scan.rotation, start[2].world_from_scan.rotation);
    for (std::size_t i = 0; i < scene.truth.size(); ++i)
        EXPECT_LT(angle_between(result.scans[i].world_from_scan, moved * scene.truth[i]) / kDegree,
                  0.02);
}

TEST(RegisterJointly, SaysWhichScanOverlapsWithNothing) {
    Scene scene = make_scene(4, 0.0, 7);
    std::mt19937 rng(8);
    auto start = disturbed(scene, 1 * kDegree, 1, rng);
    start[3].world_from_scan.translation += Vector3d(1000, 0, 0);
    const Rigid3 before = start[3].world_from_scan;
    const JointResult result = register_jointly(scene.scans, start);
    EXPECT_FALSE(result.converged);
    EXPECT_NE(result.reason.find("scan 3 has no overlap"), std::string::npos) << result.reason;
    EXPECT_EQ(result.scans[3].open_directions, 6);
    EXPECT_TRUE(std::isinf(result.scans[3].sigma_mm));
    EXPECT_EQ(result.scans[3].world_from_scan.translation, before.translation);
}

RangeImage plane_view(double sigma_mm, unsigned seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> noise(0.0, sigma_mm > 0 ? sigma_mm : 1.0);
    RangeImage image = make_range_image(120, 120);
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 120; ++x) {
            RangePoint& point = image.points[image.cell(x, y)];
            image.mask[image.cell(x, y)] = 1;
            point.position = Vector3d(0.5 * x, -0.5 * y, sigma_mm > 0 ? noise(rng) : 0.0);
            point.error_direction = -Eigen::Vector3f::UnitZ();
            point.sigma_mm = static_cast<float>(sigma_mm);
        }
    return image;
}

TEST(RegisterJointly, LeavesAPlaneFreeToSlideAndSaysSo) {
    for (const double sigma : {0.0, 0.03}) {
        std::vector<ScanSurface> scans;
        scans.push_back(prepare_surface(plane_view(sigma, 1)));
        scans.push_back(prepare_surface(plane_view(sigma, 2)));
        std::vector<ScanPose> start(2);
        const Vector3d centre(30, -30, 0);
        start[1].world_from_scan.rotation = rotation_from_vector(Vector3d(0.02, 0.01, 0.05));
        start[1].world_from_scan.translation =
            centre - start[1].world_from_scan.rotation * centre + Vector3d(1.5, 0.5, 0.8);
        const JointResult result = register_jointly(scans, start);
        EXPECT_FALSE(result.converged);
        EXPECT_EQ(result.scans[1].open_directions, 3) << sigma << " " << result.reason;
        const Rigid3& found = result.scans[1].world_from_scan;
        // Put on the plane, within what 10000 points of that noise allow ...
        EXPECT_NEAR((found * centre).z(), 0.0, 0.003);
        EXPECT_NEAR(found.rotation(2, 2), 1.0, 1e-6);
        // ... and not slid or spun to follow the noise.
        EXPECT_NEAR((found * centre).x(), 31.5, 0.05) << sigma;
        EXPECT_NEAR((found * centre).y(), -29.5, 0.05) << sigma;
        EXPECT_NEAR(vector_from_rotation(found.rotation).z(), 0.05, 0.002) << sigma;
    }
}

TEST(RegisterJointly, AnswersDegenerateInput) {
    EXPECT_FALSE(register_jointly(std::vector<ScanSurface>{}, {}).converged);
    std::vector<ScanSurface> scans;
    scans.push_back(prepare_surface(make_range_image(0, 0)));
    scans.push_back(prepare_surface(plane_view(0, 1)));
    std::vector<ScanPose> start(2);
    const JointResult result = register_jointly(scans, start);
    EXPECT_FALSE(result.converged);
    EXPECT_EQ(result.scans[1].matches, 0U);

    EXPECT_THROW(register_jointly(scans, std::vector<ScanPose>(1)), std::invalid_argument);
    start[1].world_from_scan.translation.x() = std::nan("");
    EXPECT_THROW(register_jointly(scans, start), std::invalid_argument);
    start[1].world_from_scan = {};
    EXPECT_THROW(register_jointly(scans, start, {.samples_per_scan = 0}), std::invalid_argument);
    EXPECT_EQ(validate(JointOptions{}), "");
}

}  // namespace
}  // namespace stria
